// Reading rig files into a value that cannot be invalid.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/rig.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <set>

#include "pipeline/frame/error.h"
#include "pipeline/optics/calibration.h"
#include "pipeline/optics/config_path.h"
#include "pipeline/portable/portable_math.h"
#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

constexpr double kMostPixels = 65535.0;
constexpr double kFarthestPosition = 100.0;  // metres
// exp(-64) is 1e-28: every texel of a footprint still weighs something, however few and far they are.
constexpr double kFaintest = 64.0;
constexpr std::array<std::string_view, 6> kFrameModels = {"fisheye",  "equirectangular", "cylindrical",
                                                          "mercator", "chrome-ball",     "cube"};

// Turns by `radians` about x, from -z towards +y.
Mat3 turn_up(double radians) {
  const auto [s, c] = portable::sine_cosine(radians);
  return {Vec3{1, 0, 0}, Vec3{0, c, s}, Vec3{0, -s, c}};
}

void read_circle(SettingsTable& table, FrameGeometry& frame) {
  frame.center = {frame.size.width / 2.0, frame.size.height / 2.0};
  if (table.has("center")) {
    const std::vector<double> center = table.numbers("center", 2, 2);
    frame.center = {center[0], center[1]};
    if (std::abs(center[0]) > kMostPixels || std::abs(center[1]) > kMostPixels) {
      table.refuse("center", "expected pixels within 65535 of the frame's corner");
    }
  }
  frame.radius =
      table.number("radius", 0.5, kMostPixels, std::min(frame.size.width, frame.size.height) / 2.0);
}

// layout = "3x2" (columns x rows) and faces = [names], which fill the frame's atlas row by row.
void read_cube(SettingsTable& table, FrameGeometry& frame) {
  const std::string layout = table.text("layout");
  int columns = 0;
  int rows = 0;
  char rest = 0;
  if (std::sscanf(layout.c_str(), "%2dx%2d%c", &columns, &rows, &rest) != 2 || columns < 1 || rows < 1 ||
      columns * rows > 6) {
    table.refuse("layout", "expected columns x rows of at most 6 faces, like \"3x2\"");
    table.may_have({"faces"});
    return;
  }
  const bool sized = !table.refused("width") && !table.refused("height");
  if (sized && (frame.size.width % columns != 0 || frame.size.height % rows != 0)) {
    table.refuse("layout", "expected a frame whose sides divide evenly into the layout");
  }
  const auto count = static_cast<std::size_t>(columns * rows);
  const std::vector<std::string> names = table.texts("faces", count, count);
  frame.columns = columns;
  for (const std::string& name : names) {
    View face;
    if (!named_pose(name, face)) {
      table.refuse("faces", fmt::format("expected front, left, right, top, bottom or back, not {}", name));
    }
    face.name = name;
    face.size = {frame.size.width / columns, frame.size.height / rows};
    frame.faces.push_back(face);
  }
}

FrameGeometry read_frame(SettingsTable& table) {
  FrameGeometry frame;
  frame.model = static_cast<FrameModel>(table.choice("model", kFrameModels, 0));
  frame.size.width = static_cast<int>(table.integer("width", 1, 65535));
  frame.size.height = static_cast<int>(table.integer("height", 1, 65535));
  constexpr std::array<std::string_view, 2> kCrops = {"none", "omnimax"};
  frame.crop = static_cast<Crop>(table.choice("crop", kCrops, 0));
  if (table.refused("model")) {  // center and radius are read below
    table.text("layout", "");
    table.may_have({"faces"});
    table.number("fov_deg", 1.0, 360.0, 360.0);
  }
  if (frame.model == FrameModel::kFisheye || frame.model == FrameModel::kChromeBall) {
    read_circle(table, frame);
  } else if (frame.model == FrameModel::kCube) {
    read_cube(table, frame);
  } else {
    frame.fov = portable::radians(table.number("fov_deg", 1.0, 360.0, 360.0));
  }
  table.finish();
  return frame;
}

// Numbers that a kernel has no use for are refused beside it, rather than ignored.
void refuse_strangers(SettingsTable& table, Kernel kernel, std::string_view name) {
  const auto only_with = [&](std::string_view key, bool right, std::string_view whose) {
    if (!right && table.has(key)) {
      table.refuse(key, fmt::format("expected no {} beside kernel {}: it belongs to {}", key, name, whose));
    }
  };
  only_with("alpha", kernel == Kernel::kGaussian, "gaussian");
  only_with("radius", kernel != Kernel::kOptimal, "gaussian, robidoux and jinc");
  only_with("rec", kernel != Kernel::kOptimal, "gaussian, robidoux and jinc");
  only_with("noise", kernel == Kernel::kOptimal, "optimal");
}

// A budget picks the filter: whatever else says something about it would contradict it.
std::optional<double> read_budget(SettingsTable& table) {
  const double budget_ms = table.number("budget_ms", 0.01, 10000.0, 1.0);
  if (!table.has("budget_ms")) return std::nullopt;
  for (const std::string_view key : {"preset", "kernel", "alpha", "radius", "rec", "noise", "table"}) {
    if (!table.has(key)) continue;
    table.refuse(key, fmt::format("expected no {} beside budget_ms, which picks the filter", key));
  }
  return budget_ms;
}

FilterSettings read_filter(SettingsTable& table) {
  constexpr std::array<std::string_view, 2> kPresets = {"default", "paper"};
  const bool paper = table.choice("preset", kPresets, 0) == 1;
  FilterSettings filter = paper ? paper_preset() : FilterSettings{};
  constexpr std::array<std::string_view, 4> kKernels = {"gaussian", "robidoux", "jinc", "optimal"};
  const std::size_t kernel = table.choice("kernel", kKernels, static_cast<std::size_t>(filter.kernel));
  const bool known = !table.refused("preset") && !table.refused("kernel");
  if (static_cast<Kernel>(kernel) != filter.kernel) {
    if (paper) table.refuse("kernel", "expected gaussian, which is what preset \"paper\" means");
    const std::array<FilterSettings, 4> own = {default_gaussian(), robidoux_filter(), jinc_filter(),
                                               optimal_filter()};
    filter = own[kernel];
  }
  if (known) refuse_strangers(table, filter.kernel, kKernels[kernel]);
  filter.alpha = table.number("alpha", 0.01, 50.0, filter.alpha);
  filter.radius = table.number("radius", 0.25, 8.0, filter.radius);
  filter.rec = table.number("rec", 0.0, 16.0, filter.rec);
  filter.noise = table.number("noise", 1e-6, 1.0, filter.noise);
  const bool numbers = known && !table.refused("alpha") && !table.refused("radius");
  if (numbers && filter.kernel == Kernel::kGaussian &&
      filter.alpha * filter.radius * filter.radius > kFaintest) {
    table.refuse(table.has("alpha") || !table.has("radius") ? "alpha" : "radius",
                 fmt::format("expected alpha x radius^2 of at most {}: weights at the footprint's rim vanish",
                             kFaintest));
  }
  constexpr std::array<std::string_view, 3> kForms = {"fast", "precise", "compact"};
  filter.table =
      static_cast<TableForm>(table.choice("table", kForms, static_cast<std::size_t>(filter.table)));
  return filter;
}

SampleSettings read_samples(SettingsTable& table) {
  constexpr std::array<std::string_view, 2> kLights = {"encoded", "linear"};
  SampleSettings samples;
  samples.linear_light = table.choice("light", kLights, 0) == 1;
  samples.dither = table.flag("dither", samples.dither);
  if (samples.linear_light && table.has("budget_ms"))
    table.refuse("light", "expected encoded beside budget_ms, which picks among filters without light");
  return samples;
}

Vec3 read_vector(SettingsTable& table, std::string_view key) {
  const std::vector<double> v = table.numbers(key, 3, 3);
  const Vec3 vector{v[0], v[1], v[2]};
  const double length = glm::length(vector);
  if (!(length > 1e-6 && length < 1e6)) {
    table.refuse(key, "expected a direction [x, y, z] that is not zero");
    return {0, 0, -1};
  }
  return vector / length;
}

void read_pose(SettingsTable& table, View& view) {
  const bool named = named_pose(view.name, view);
  if (!table.has("forward") && !table.has("up")) {
    if (!named) {
      table.refuse("name",
                   "expected front, left, right, top, bottom or back, or forward and up beside another name");
    }
    return;
  }
  view.forward = read_vector(table, "forward");
  const Vec3 up = read_vector(table, "up");
  const Vec3 right = glm::cross(view.forward, up);
  if (glm::length(right) < 1e-6) {
    if (!table.refused("forward")) {
      table.refuse("up", "expected a direction that is not parallel to forward");
    }
    return;
  }
  view.right = glm::normalize(right);
  view.up = glm::cross(view.right, view.forward);
}

// Metres from the rig's centre.
Vec3 read_position(SettingsTable& table) {
  if (!table.has("position_m")) return Vec3{0.0};
  const std::vector<double> p = table.numbers("position_m", 3, 3);
  const Vec3 position{p[0], p[1], p[2]};
  if (!(glm::length(position) <= kFarthestPosition)) {
    table.refuse("position_m",
                 fmt::format("expected [x, y, z] within {} metres of the rig's centre", kFarthestPosition));
    return Vec3{0.0};
  }
  return position;
}

// After the views: an error in one of their positions is none of the distance.
void read_seam_distance(SettingsTable& seams, Rig& rig) {
  rig.seams.distance_m = seams.number("distance_m", 0.01, 1e6, HUGE_VAL);
  if (set_shifts(rig.views, rig.seams.distance_m)) return;
  const auto farthest = std::max_element(
      rig.views.begin(), rig.views.end(),
      [](const View& a, const View& b) { return glm::length(a.position_m) < glm::length(b.position_m); });
  const double length = glm::length(farthest->position_m);
  seams.refuse(
      "distance_m",
      fmt::format(
          "expected at least {:.4g}: {} times as far as view {}, which is {:.4g} m off the rig's centre",
          kLeastSeamDistance * length, kLeastSeamDistance, farthest->name, length));
}

View read_view(SettingsTable table, const std::filesystem::path& directory) {
  View view;
  view.name = table.text("name");
  read_pose(table, view);
  view.position_m = read_position(table);
  if (table.has("calibration")) {
    if (table.has("fov_deg") || table.has("fov_y_deg")) {
      table.refuse("calibration", "expected either a calibration or fov_deg, not both");
      table.may_have({"fov_deg", "fov_y_deg"});
    }
    const std::string file = table.text("calibration");
    if (!table.refused("calibration")) {
      table.attempt("calibration", [&] { read_calibration(directory / file, view); });
    }
  } else {
    const double fov_x = table.number("fov_deg", 0.1, 179.0, 90.0);
    const double fov_y = table.number("fov_y_deg", 0.1, 179.0, fov_x);
    // At 90 degrees exactly one half, so that faces meet on their edges to the bit.
    const auto focal = [](double fov) {
      return fov == 90.0 ? 0.5 : 0.5 / portable::tangent(portable::radians(fov / 2));
    };
    view.focal = {focal(fov_x), focal(fov_y)};
  }
  if (table.has("size")) {
    const std::vector<double> size = table.numbers("size", 2, 2);
    for (const double side : size) {
      if (!(side >= 1.0 && side <= kMostPixels && side == std::floor(side))) {
        table.refuse("size", "expected [width, height] in texels, from 1 to 65535");
      }
    }
    if (!table.refused("size")) view.size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
  }
  table.finish();
  return view;
}

}  // namespace

Rig load_rig(const std::filesystem::path& file, std::span<const std::string> overrides,
             SettingsErrors* errors) {
  SettingsTable table = load_settings(file, overrides, errors);
  const std::filesystem::path directory = file.parent_path();
  Rig rig;
  rig.file = file;
  constexpr std::array<std::string_view, 2> kFollow = {"axis", "world"};
  const bool world = table.choice("views", kFollow, 0) == 1;
  rig.tilt_deg = table.number("tilt_deg", -180.0, 180.0, 0.0);
  if (!table.has("frame")) table.refuse("frame", "expected a table [frame] with width and height");
  SettingsTable frame = table.table("frame");
  rig.frame = read_frame(frame);
  const bool model_known = !frame.refused("model") && !table.refused("frame");
  if (rig.frame.model == FrameModel::kFisheye && (model_known || table.has("lens"))) {
    if (!table.has("lens")) table.refuse("lens", "expected a table [lens] with a model");
    SettingsTable lens = table.table("lens");
    rig.frame.lens = read_lens(lens, directory);
  }
  SettingsTable filter = table.table("filter");
  rig.budget_ms = read_budget(filter);
  rig.filter = read_filter(filter);
  rig.samples = read_samples(filter);
  // What is dark beside what is bright shows every error of weights: 16 bits unless told otherwise.
  if (rig.samples.linear_light && !filter.has("table")) rig.filter.table = TableForm::kPrecise;
  filter.finish();
  SettingsTable seams = table.table("seams");
  rig.seams.feather_deg = seams.number("feather_deg", 0.0, 45.0, 0.0);

  const double tilt = portable::radians(rig.tilt_deg);
  if (rig.tilt_deg != 0.0) rig.world_from_lens = turn_up(tilt);
  const Mat3 lens_from_world = rig.tilt_deg != 0.0 ? turn_up(-tilt) : Mat3{1.0};
  std::set<std::string> names;
  for (SettingsTable& entry : table.tables("view")) {
    const std::string name = entry.text("name");
    if (!names.insert(name).second && !entry.refused("name")) {
      entry.refuse("name",
                   fmt::format("expected a name of its own, but another view is called {} already", name));
    }
    if (rig.views.size() == 6) entry.refuse("name", "expected at most six views");
    View view = read_view(std::move(entry), directory);
    if (world) {
      view.forward = lens_from_world * view.forward;
      view.right = lens_from_world * view.right;
      view.up = lens_from_world * view.up;
      view.position_m = lens_from_world * view.position_m;
    }
    rig.views.push_back(std::move(view));
  }
  read_seam_distance(seams, rig);
  seams.finish();
  if (rig.views.empty()) table.refuse("view", "expected one to six tables [[view]]");
  // The installation's hardware is in the same file, for others to read.
  table.tables("camera");
  table.table("sync");
  table.table("colour");
  table.table("exposure");
  table.table("gpio");
  table.table("display");
  table.finish();
  return rig;
}

void set_view_sizes(Rig& rig, std::span<const Size> sizes) {
  if (sizes.size() != rig.views.size()) {
    throw InputError(fmt::format("{}: expected pictures for {} views, not {}", rig.file.string(),
                                 rig.views.size(), sizes.size()));
  }
  for (std::size_t i = 0; i < sizes.size(); ++i) {
    View& view = rig.views[i];
    if (sizes[i].width < 1 || sizes[i].height < 1) {
      throw InputError(
          fmt::format("{}: view {}: expected a picture with a size", rig.file.string(), view.name));
    }
    if (view.size.width != 0 && !(view.size == sizes[i])) {
      throw InputError(fmt::format("{}: view {}: expected a picture of {} x {} texels, not {} x {}",
                                   rig.file.string(), view.name, view.size.width, view.size.height,
                                   sizes[i].width, sizes[i].height));
    }
    view.size = sizes[i];
  }
}

}  // namespace cupola
