// The plot of time against error, drawn once onto an SVG and a PNG surface.
// SPDX-License-Identifier: MIT
#include <cairo-svg.h>
#include <cairo.h>
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <memory>

#include "firmware/pareto.h"
#include "pipeline/frame/atomic_file.h"

namespace cupola {
namespace {

constexpr double kPanelWidth = 620.0;
constexpr double kHeight = 560.0;
constexpr double kLeft = 60.0;
constexpr double kRight = 20.0;
constexpr double kTop = 50.0;
constexpr double kBottom = 56.0;

struct Destroy {
  void operator()(cairo_surface_t* surface) const { cairo_surface_destroy(surface); }
  void operator()(cairo_t* cairo) const { cairo_destroy(cairo); }
};
using Surface = std::unique_ptr<cairo_surface_t, Destroy>;
using Cairo = std::unique_ptr<cairo_t, Destroy>;

struct Colour {
  double r, g, b;
};
constexpr Colour kInk{0.1, 0.1, 0.15};
constexpr Colour kFaint{0.88, 0.88, 0.9};
constexpr Colour kOurs{0.55, 0.62, 0.75};
constexpr Colour kBest{0.05, 0.35, 0.75};
constexpr Colour kPeer{0.8, 0.3, 0.1};

class PanelDrawing {
 public:
  PanelDrawing(cairo_t* cairo, const ParetoPanel& panel, double x) : cairo_(cairo), panel_(panel), x_(x) {
    least_time_ = least_error_ = 1e300;
    for (const ParetoMark& mark : panel.marks) {
      least_time_ = std::min(least_time_, mark.ns_per_pixel);
      most_time_ = std::max(most_time_, mark.ns_per_pixel);
      least_error_ = std::min(least_error_, mark.error);
      most_error_ = std::max(most_error_, mark.error);
    }
    least_time_ /= 1.4;
    most_time_ *= 2.5;  // room for names
    least_error_ /= 1.25;
    most_error_ *= 1.15;
  }

  void draw() {
    axes();
    frontier();
    for (const ParetoMark& mark : panel_.marks) dot(mark);
    names();
  }

 private:
  double across(double time) const {
    const double share = std::log(time / least_time_) / std::log(most_time_ / least_time_);
    return x_ + kLeft + share * (kPanelWidth - kLeft - kRight);
  }
  double down(double error) const {
    const double share = std::log(error / least_error_) / std::log(most_error_ / least_error_);
    return kHeight - kBottom - share * (kHeight - kTop - kBottom);
  }
  void colour(const Colour& c) { cairo_set_source_rgb(cairo_, c.r, c.g, c.b); }
  void line(double x0, double y0, double x1, double y1) {
    cairo_move_to(cairo_, x0, y0);
    cairo_line_to(cairo_, x1, y1);
    cairo_stroke(cairo_);
  }
  double width(const std::string& text) {
    cairo_text_extents_t extents;
    cairo_text_extents(cairo_, text.c_str(), &extents);
    return extents.x_advance;
  }
  void text(const std::string& text, double x, double y) {
    cairo_move_to(cairo_, x, y);
    cairo_show_text(cairo_, text.c_str());
  }

  void axes() {
    cairo_set_line_width(cairo_, 1.0);
    cairo_set_font_size(cairo_, 12.0);
    for (double decade = 1e-3; decade < 1e7; decade *= 10.0) {
      for (const double step : {1.0, 2.0, 5.0}) {
        const double at = decade * step;
        const std::string label = fmt::format("{:g}", at);
        if (at > least_time_ && at < most_time_) {
          colour(kFaint);
          line(across(at), kTop, across(at), kHeight - kBottom);
          colour(kInk);
          text(label, across(at) - width(label) / 2, kHeight - kBottom + 16);
        }
        if (at > least_error_ && at < most_error_) {
          colour(kFaint);
          line(x_ + kLeft, down(at), x_ + kPanelWidth - kRight, down(at));
          colour(kInk);
          text(label, x_ + kLeft - width(label) - 6, down(at) + 4);
        }
      }
    }
    colour(kInk);
    line(x_ + kLeft, kTop, x_ + kLeft, kHeight - kBottom);
    line(x_ + kLeft, kHeight - kBottom, x_ + kPanelWidth - kRight, kHeight - kBottom);
    text("time, ns a pixel on one core", x_ + kPanelWidth / 2 - 70, kHeight - 14);
    text("error, RMS against the pixel integral, 8-bit steps", x_ + kLeft - 50, kTop - 8);
    cairo_set_font_size(cairo_, 15.0);
    text(panel_.title, x_ + kLeft - 50, 22);
  }

  void frontier() {
    std::vector<const ParetoMark*> best;
    for (const ParetoMark& mark : panel_.marks) {
      if (mark.frontier) best.push_back(&mark);
    }
    std::sort(best.begin(), best.end(), [](auto* a, auto* b) { return a->ns_per_pixel < b->ns_per_pixel; });
    colour(kBest);
    cairo_set_line_width(cairo_, 1.6);
    for (std::size_t i = 0; i < best.size(); ++i) {
      if (i == 0) {
        cairo_move_to(cairo_, across(best[i]->ns_per_pixel), kTop);
      } else {
        cairo_line_to(cairo_, across(best[i]->ns_per_pixel), down(best[i - 1]->error));
      }
      cairo_line_to(cairo_, across(best[i]->ns_per_pixel), down(best[i]->error));
    }
    if (!best.empty()) cairo_line_to(cairo_, x_ + kPanelWidth - kRight, down(best.back()->error));
    cairo_stroke(cairo_);
  }

  void dot(const ParetoMark& mark) {
    const double x = across(mark.ns_per_pixel);
    const double y = down(mark.error);
    colour(mark.peer ? kPeer : mark.frontier ? kBest : kOurs);
    if (mark.peer) {
      cairo_rectangle(cairo_, x - 4, y - 4, 8, 8);
    } else {
      cairo_arc(cairo_, x, y, mark.frontier ? 4.5 : 3.5, 0, 6.2832);
    }
    cairo_fill(cairo_);
  }

  // Names of the frontier, the peers and what has room, none over another.
  void names() {
    cairo_set_font_size(cairo_, 11.0);
    struct Box {
      double x0, y0, x1, y1;
    };
    std::vector<Box> taken;
    std::vector<const ParetoMark*> order;
    for (const ParetoMark& mark : panel_.marks) order.push_back(&mark);
    std::stable_sort(order.begin(), order.end(),
                     [](auto* a, auto* b) { return (a->frontier || a->peer) > (b->frontier || b->peer); });
    for (const ParetoMark* mark : order) {
      const double w = width(mark->name);
      const double x = across(mark->ns_per_pixel);
      const double y = down(mark->error);
      for (const auto& [dx, dy] : {std::pair{7.0, 4.0},
                                   {7.0, -7.0},
                                   {7.0, 15.0},
                                   {-w - 7.0, 4.0},
                                   {-w - 7.0, -7.0},
                                   {-w - 7.0, 15.0}}) {
        const Box box{x + dx - 1, y + dy - 10, x + dx + w + 1, y + dy + 3};
        const bool free =
            box.x0 > x_ + kLeft && box.x1 < x_ + kPanelWidth - 2 &&
            std::none_of(taken.begin(), taken.end(), [&](const Box& other) {
              return box.x0 < other.x1 && other.x0 < box.x1 && box.y0 < other.y1 && other.y0 < box.y1;
            });
        if (!free) continue;
        taken.push_back(box);
        colour(mark->peer ? kPeer : mark->frontier ? kBest : kInk);
        text(mark->name, x + dx, y + dy);
        break;
      }
    }
  }

  cairo_t* cairo_;
  const ParetoPanel& panel_;
  double x_;
  double least_time_, most_time_ = 0.0;
  double least_error_, most_error_ = 0.0;
};

void draw(cairo_surface_t* surface, std::span<const ParetoPanel> panels) {
  const Cairo cairo(cairo_create(surface));
  cairo_set_source_rgb(cairo.get(), 1, 1, 1);
  cairo_paint(cairo.get());
  cairo_select_font_face(cairo.get(), "sans-serif", CAIRO_FONT_SLANT_NORMAL, CAIRO_FONT_WEIGHT_NORMAL);
  for (std::size_t i = 0; i < panels.size(); ++i) {
    PanelDrawing(cairo.get(), panels[i], kPanelWidth * static_cast<double>(i)).draw();
  }
  cairo_surface_flush(surface);
}

cairo_status_t append(void* bytes, const unsigned char* data, unsigned length) {
  static_cast<std::string*>(bytes)->append(reinterpret_cast<const char*>(data), length);
  return CAIRO_STATUS_SUCCESS;
}

void write(const std::filesystem::path& target, const std::string& bytes) {
  AtomicFile file(target);
  file.write(bytes);
  file.commit();
}

}  // namespace

bool draw_pareto(std::span<const ParetoPanel> panels, const std::filesystem::path& file) {
  const double width = kPanelWidth * static_cast<double>(panels.size());
  std::string svg;
  std::string png;
  Surface vector(cairo_svg_surface_create_for_stream(append, &svg, width, kHeight));
  draw(vector.get(), panels);
  cairo_surface_finish(vector.get());
  const Surface pixels(
      cairo_image_surface_create(CAIRO_FORMAT_RGB24, static_cast<int>(width), static_cast<int>(kHeight)));
  draw(pixels.get(), panels);
  cairo_surface_write_to_png_stream(pixels.get(), append, &png);
  write(std::filesystem::path(file).replace_extension("svg"), svg);
  write(std::filesystem::path(file).replace_extension("png"), png);
  return true;
}

}  // namespace cupola
