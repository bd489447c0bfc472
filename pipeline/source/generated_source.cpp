// Faces drawn from a generated world: its backdrop once, at the start; what moves in it anew each frame.
// SPDX-License-Identifier: MIT
#include "pipeline/source/generated_source.h"

#include <algorithm>
#include <atomic>
#include <cassert>
#include <cmath>
#include <cstring>

#include <glm/common.hpp>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr int kBandRows = 8;  // of one task; texels share their corners within a band

// Directions across the plane of an undistorted view from the centre, without the divisions of
// direction_at().
class TexelRays {
 public:
  explicit TexelRays(const View& view)
      : view_(view), straight_(view.distortion == Distortion::kNone && !is_shifted(view)) {
    if (!straight_) return;
    per_u_ = view.right / (view.focal.x * view.size.width);
    per_v_ = -view.up / (view.focal.y * view.size.height);
    corner_ = view.forward - per_u_ * (view.principal.x * view.size.width) -
              per_v_ * (view.principal.y * view.size.height);
  }
  Vec3 at(double u, double v) const {
    if (!straight_) return direction_at(view_, {u, v});
    const Vec3 d = corner_ + u * per_u_ + v * per_v_;
    return d * (1.0 / std::sqrt(glm::dot(d, d)));
  }

 private:
  const View& view_;
  bool straight_;
  Vec3 corner_{0.0}, per_u_{0.0}, per_v_{0.0};
};

struct Tally {
  Vec3 sum{0.0}, least{2.0}, most{-1.0};
  void add(const Vec3& colour) {
    sum += colour;
    least = glm::min(least, colour);
    most = glm::max(most, colour);
  }
  double range() const {
    const Vec3 r = most - least;
    return std::max(r.x, std::max(r.y, r.z));
  }
};

Tally sample_grid(const World& world, const TexelRays& rays, int x, int y, int side) {
  Tally tally;
  for (int b = 0; b < side; ++b) {
    for (int a = 0; a < side; ++a) {
      tally.add(world.backdrop(rays.at(x + (a + 0.5) / side, y + (b + 0.5) / side)));
    }
  }
  tally.sum /= side * side;
  return tally;
}

// The mean over a texel that varies within: as many samples as it takes.
Vec3 refined(const World& world, const TexelRays& rays, int x, int y) {
  const Tally four = sample_grid(world, rays, x, y, 4);
  if (four.range() < 0.1) return four.sum;
  const Tally eight = sample_grid(world, rays, x, y, 8);
  const Vec3 change = glm::abs(eight.sum - four.sum);
  if (std::max(change.x, std::max(change.y, change.z)) < 4.0 / 255.0) return eight.sum;
  return sample_grid(world, rays, x, y, 16).sum;
}

std::uint16_t to_16_bits(double value) {
  return static_cast<std::uint16_t>(std::clamp(value, 0.0, 1.0) * 65535.0 + 0.5);
}

TexelBox whole(Size size) {
  return {0, 0, size.width, size.height};
}

// The part of `row` of a box that is needed.
RowSpan within(const TexelBox& box, const RowSpan& row) {
  return {std::max(box.x0, row.first), std::min(box.x1, row.last)};
}

}  // namespace

GeneratedSource::GeneratedSource(std::span<const View> views, const Mat3& world_from_lens,
                                 std::unique_ptr<const World> world, double frames_per_second,
                                 WorkerPool& pool, Size default_size, PixelFormat format)
    : world_(std::move(world)), frames_per_second_(frames_per_second), pool_(pool), format_(format) {
  if (!world_) throw InputError("no such generated world");
  if (format != PixelFormat::kRgbPlanar8 && format != PixelFormat::kRgbPlanar16) {
    throw InputError("generated faces are planar RGB");
  }
  const Mat3 rotation = world_rotation(*world_, world_from_lens);
  for (const View& view : views) {
    Face face;
    face.view = view;
    face.view.forward = rotation * view.forward;
    face.view.right = rotation * view.right;
    face.view.up = rotation * view.up;
    face.view.shift = rotation * view.shift;
    if (face.view.size == Size{}) face.view.size = default_size;
    const Size size = face.view.size;
    const double focal = std::min(view.focal.x * size.width, view.focal.y * size.height);  // texels
    face.texel = 0.75 / focal * (1.0 + glm::length(view.shift));
    face.reach = -2.0;
    if (view.distortion == Distortion::kNone && !is_shifted(view)) {
      for (const Vec2 corner : {Vec2{0, 0}, Vec2{0, 1}, Vec2{1, 0}, Vec2{1, 1}}) {
        const Vec2 tangents = (corner - view.principal) / view.focal;
        const double cosine = 1.0 / std::sqrt(1.0 + glm::dot(tangents, tangents));
        face.reach = corner == Vec2{0, 0} ? cosine : std::min(face.reach, cosine);
      }
    }
    faces_.push_back(std::move(face));
  }
}

std::vector<Size> GeneratedSource::face_sizes() const {
  std::vector<Size> sizes;
  for (const Face& face : faces_) sizes.push_back(face.view.size);
  return sizes;
}

void GeneratedSource::prepare(std::span<const NeededRegion> needed) {
  assert(needed.size() == faces_.size());
  sprites_.resize(static_cast<std::size_t>(world_->sprites()));
  next_sprites_ = sprites_;
  changed_.clear();
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    Face& face = faces_[f];
    const Size size = face.view.size;
    assert(needed[f].size == size);
    changed_.emplace_back(size);
    face.needed = needed[f];
    face.backdrop = ImageBuffer(PixelFormat::kRgbPlanar16, size);
    face.uneven.assign(static_cast<std::size_t>(size.width) * static_cast<std::size_t>(size.height), 0);
    face.boxes.assign(sprites_.size(), {});

    pool_.run((size.height + kBandRows - 1) / kBandRows, [&](int band) {
      draw_backdrop(face, band * kBandRows, std::min(size.height, (band + 1) * kBandRows));
    });
    const std::int64_t texels = face.needed.texels();
    texels_drawn_ += texels;
    texels_skipped_ += std::int64_t{size.width} * size.height - texels;

    if (!sprites_.empty()) {
      face.canvas = ImageBuffer(PixelFormat::kRgbPlanar16, size);
      clear(face, whole(size));
    }
    if (format_ == PixelFormat::kRgbPlanar8) {
      face.output = ImageBuffer(PixelFormat::kRgbPlanar8, size);
      put_out(face, whole(size));
    }
  }
}

void GeneratedSource::draw_backdrop(Face& face, int first_row, int last_row) const {
  // A texel is taken for linear when its corners and middle differ little and agree in their mean: an edge
  // through it would part the two.
  constexpr double kGentle = 16.0 / 255.0, kAgreed = 1.0 / 255.0;
  const TexelRays rays(face.view);
  const int width = face.view.size.width;
  const auto span_of = [&](int y) {
    return y < first_row || y >= last_row ? RowSpan{} : face.needed.rows[static_cast<std::size_t>(y)];
  };
  std::vector<Vec3> above(static_cast<std::size_t>(width) + 1), below = above;
  for (int y = first_row; y <= last_row; ++y) {
    // The corners between rows y - 1 and y, as far as either needs them.
    above.swap(below);
    const RowSpan upper = span_of(y - 1), lower = span_of(y);
    for (int x = 0; x <= width; ++x) {
      const auto touches = [x](const RowSpan& span) {
        return !span.empty() && x >= span.first && x <= span.last;
      };
      if (touches(upper) || touches(lower))
        below[static_cast<std::size_t>(x)] = world_->backdrop(rays.at(x, y));
    }
    for (int x = upper.first; x < upper.last; ++x) {
      const int row = y - 1;
      Tally tally;
      for (const auto& corners : {&above, &below}) {
        tally.add((*corners)[static_cast<std::size_t>(x)]);
        tally.add((*corners)[static_cast<std::size_t>(x) + 1]);
      }
      const Vec3 middle = world_->backdrop(rays.at(x + 0.5, row + 0.5));
      const Vec3 corner_sum = tally.sum;
      tally.add(middle);
      const Vec3 bulge = glm::abs(0.25 * corner_sum - middle);
      const bool even = tally.range() < kGentle && std::max(bulge.x, std::max(bulge.y, bulge.z)) < kAgreed;
      const Vec3 mean = even ? (corner_sum + 8.0 * middle) / 12.0 : refined(*world_, rays, x, row);
      face.uneven[static_cast<std::size_t>(row) * static_cast<std::size_t>(width) + x] = !even;
      for (int p = 0; p < 3; ++p) {
        face.backdrop.pixels().samples<std::uint16_t>(p, row)[x] = to_16_bits(mean[p]);
      }
    }
  }
}

// The canvas as it is without sprites.
void GeneratedSource::clear(Face& face, const TexelBox& box) const {
  for (int y = box.y0; y < box.y1; ++y) {
    const RowSpan span = within(box, face.needed.rows[static_cast<std::size_t>(y)]);
    if (span.empty()) continue;
    const auto bytes = static_cast<std::size_t>(span.last - span.first) * sizeof(std::uint16_t);
    for (int p = 0; p < 3; ++p) {
      std::memcpy(face.canvas.pixels().samples<std::uint16_t>(p, y) + span.first,
                  face.backdrop.pixels().samples<std::uint16_t>(p, y) + span.first, bytes);
    }
  }
}

void GeneratedSource::draw(Face& face, const Sprite& sprite, const TexelBox& box) {
  // One point will do well within a rim, Gauss's two a side where all is smooth, a grid across the rim.
  static constexpr double kGauss[] = {0.5 - 0.28867513459481288, 0.5 + 0.28867513459481288};
  static constexpr double kGrid[] = {1.0 / 6.0, 0.5, 5.0 / 6.0};
  const TexelRays rays(face.view);
  const MutableImage& canvas = face.canvas.pixels();
  const double reach = std::cos(sprite.cone.angle + face.texel);
  const double inner = sprite.rim > 0.0 ? std::cos(sprite.rim) : 2.0;
  for (int y = box.y0; y < box.y1; ++y) {
    const RowSpan span = within(box, face.needed.rows[static_cast<std::size_t>(y)]);
    for (int x = span.first; x < span.last; ++x) {
      const Vec3 middle = rays.at(x + 0.5, y + 0.5);
      const double cosine = glm::dot(middle, sprite.cone.axis);
      if (cosine < reach) continue;
      ++texels_redrawn_;
      const auto put = [&](const Vec3& light, double clear) {
        for (int p = 0; p < 3; ++p) {
          std::uint16_t& sample = canvas.samples<std::uint16_t>(p, y)[x];
          sample = to_16_bits(light[p] + clear * (sample * (1.0 / 65535.0)));
        }
      };
      if (cosine >= inner) {
        const Ink ink = world_->ink(sprite, middle);
        put(ink.light, 1.0 - ink.opacity);
        continue;
      }
      const bool at_rim = sprite.rim > 0.0;
      const std::span<const double> points = at_rim ? std::span<const double>(kGrid) : kGauss;
      const bool uneven =
          at_rim &&
          face.uneven[static_cast<std::size_t>(y) * static_cast<std::size_t>(face.view.size.width) + x];
      Vec3 light{0.0}, behind{0.0}, behind_clear{0.0};
      double clear = 0.0;
      for (const double v : points) {
        for (const double u : points) {
          const Vec3 d = rays.at(x + u, y + v);
          const Ink ink = world_->ink(sprite, d);
          light += ink.light;
          clear += 1.0 - ink.opacity;
          if (uneven) {
            const Vec3 colour = world_->backdrop(d);
            behind += colour;
            behind_clear += (1.0 - ink.opacity) * colour;
          }
        }
      }
      const double count = static_cast<double>(points.size() * points.size());
      clear /= count;
      // What shows beside the rim is not the texel's mean where the backdrop varies within it.
      put((light + behind_clear - clear * behind) / count, clear);
    }
  }
}

void GeneratedSource::put_out(Face& face, const TexelBox& box) const {
  if (format_ != PixelFormat::kRgbPlanar8) return;
  ImageBuffer& from = backdrop_is_canvas() ? face.backdrop : face.canvas;
  for (int y = box.y0; y < box.y1; ++y) {
    const RowSpan span = within(box, face.needed.rows[static_cast<std::size_t>(y)]);
    for (int p = 0; p < 3; ++p) {
      const auto* wide = from.pixels().samples<std::uint16_t>(p, y);
      auto* narrow = face.output.pixels().samples<std::uint8_t>(p, y);
      // x * 255 / 65535 to nearest, exactly.
      for (int x = span.first; x < span.last; ++x) {
        narrow[x] = static_cast<std::uint8_t>((wide[x] * 255u + 32895u) >> 16);
      }
    }
  }
}

Fetch GeneratedSource::fetch(std::int64_t frame, FaceSet& faces) noexcept {
  assert(frame >= 0);
  const double seconds = static_cast<double>(frame) / frames_per_second_;
  for (std::size_t s = 0; s < next_sprites_.size(); ++s) {
    next_sprites_[s] = world_->sprite(static_cast<int>(s), seconds);
  }
  texels_redrawn_ = 0;
  const bool unchanged = fetched_ && next_sprites_ == sprites_;
  for (ChangedCells& changed : changed_) changed.clear();
  if (!unchanged && !sprites_.empty()) {
    sprites_.swap(next_sprites_);  // both are full afterwards, nothing is freed
    for (std::size_t f = 0; f < faces_.size(); ++f) {
      Face& face = faces_[f];
      const auto note = [&] {
        for (const TexelBox& box : face.boxes) changed_[f].add(box.x0, box.y0, box.x1, box.y1);
      };
      note();
      for (const TexelBox& box : face.boxes) clear(face, box);
      // Old boxes go out cleared; new ones, drawn below, go out after them.
      for (const TexelBox& box : face.boxes) put_out(face, box);
      for (std::size_t s = 0; s < sprites_.size(); ++s) {
        const Cone& cone = sprites_[s].cone;
        face.boxes[s] =
            cone.angle > 0.0 ? texels_near(face.view, cone.axis, cone.angle + face.texel) : TexelBox{};
        draw(face, sprites_[s], face.boxes[s]);
      }
      for (const TexelBox& box : face.boxes) put_out(face, box);
      note();
    }
  }
  faces.changed = fetched_ ? std::span<const ChangedCells>(changed_) : std::span<const ChangedCells>();
  fetched_ = true;

  faces.frame = frame;
  faces.faces.resize(faces_.size());
  for (std::size_t f = 0; f < faces_.size(); ++f) {
    Face& face = faces_[f];
    ImageBuffer& shown = format_ == PixelFormat::kRgbPlanar8 ? face.output
                         : backdrop_is_canvas()              ? face.backdrop
                                                             : face.canvas;
    faces.faces[f] = as_const(shown.pixels());
  }
  return unchanged ? Fetch::kUnchanged : Fetch::kNew;
}

}  // namespace cupola
