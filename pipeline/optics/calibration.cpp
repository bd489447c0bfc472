// Reading OpenCV calibration files and checking that their model is one-to-one over the picture.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/calibration.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr std::size_t kLongestFile = 1U << 20U;  // bytes
// Focal lengths and principal points beyond this many sides of the picture are mistakes.
constexpr double kMostSides = 1000.0;

// `node` is the key's value, for its line; it may be missing.
[[noreturn]] void refuse(const std::filesystem::path& file, const YAML::Node& node, const std::string& key,
                         const std::string& message) {
  if (!node || node.Mark().line < 0) throw InputError(fmt::format("{}: {}: {}", file.string(), key, message));
  throw InputError(fmt::format("{}:{}: {}: {}", file.string(), node.Mark().line + 1, key, message));
}

// OpenCV writes "%YAML:1.0", which no YAML reader but its own takes.
std::string read_yaml_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  if (!stream || std::filesystem::is_directory(file)) {
    throw InputError(fmt::format("{}: cannot be read, expected an OpenCV calibration file", file.string()));
  }
  std::string all(kLongestFile + 1, '\0');
  stream.read(all.data(), static_cast<std::streamsize>(all.size()));
  all.resize(static_cast<std::size_t>(stream.gcount()));
  if (all.size() > kLongestFile) {
    throw InputError(fmt::format("{}: expected a calibration file of at most 1 MiB", file.string()));
  }
  if (all.starts_with("%YAML")) all.erase(0, all.find('\n'));
  return all;
}

std::vector<double> numbers(const YAML::Node& root, const std::filesystem::path& file,
                            const std::string& key) {
  const YAML::Node node = root[key];
  if (!node) refuse(file, node, key, "missing, expected an OpenCV matrix");
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (!data || !data.IsSequence() || data.size() > 64)
    refuse(file, node, key, "expected an OpenCV matrix with data: [...]");
  std::vector<double> values;
  for (const YAML::Node& item : data) {
    values.push_back(item.as<double>());
    if (!std::isfinite(values.back())) refuse(file, item, key, "expected finite numbers");
  }
  return values;
}

double positive(const YAML::Node& root, const std::filesystem::path& file, const std::string& key) {
  const YAML::Node node = root[key];
  if (!node) refuse(file, node, key, "missing, expected a number of pixels");
  const auto value = node.as<double>();
  if (!(value >= 1.0 && value <= 65535.0))
    refuse(file, node, key, "expected a number of pixels from 1 to 65535");
  return value;
}

// Below the radial factor's fraction bar: where it comes to 0 the model has a pole.
double radial_divisor(const std::array<double, 8>& c, double r) {
  const double y = r * r;
  return 1.0 + y * (c[5] + y * (c[6] + y * c[7]));
}

// Slope of the distorted radius of the radial part alone.
double radial_slope(const std::array<double, 8>& c, double r) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = c;
  const double y = r * r;
  const double top = 1.0 + y * (k1 + y * (k2 + y * k3));
  const double bottom = 1.0 + y * (k4 + y * (k5 + y * k6));
  const double d_top = k1 + y * (2.0 * k2 + y * 3.0 * k3);
  const double d_bottom = k4 + y * (2.0 * k5 + y * 3.0 * k6);
  return top / bottom + 2.0 * y * (d_top - top / bottom * d_bottom) / bottom;
}

double fisheye_slope(const std::array<double, 8>& k, double angle) {
  const double y = angle * angle;
  return 1.0 + y * (3.0 * k[0] + y * (5.0 * k[1] + y * (7.0 * k[2] + y * 9.0 * k[3])));
}

// Whether the whole model, its tangential part too, keeps turning the same way round at every ideal point
// that may fall into the picture: within `reach` of the axis, where the radial part alone passes the corners.
bool turns_over(const std::array<double, 8>& c, double reach) {
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = c;
  constexpr int kRings = 64;
  constexpr int kSpokes = 64;
  for (int i = 1; i <= kRings; ++i) {
    const double r = reach * i / kRings;
    const double y = r * r;
    const double top = 1.0 + y * (k1 + y * (k2 + y * k3));
    const double bottom = 1.0 + y * (k4 + y * (k5 + y * k6));
    const double factor = top / bottom;
    const double d_factor =
        (k1 + y * (2.0 * k2 + y * 3.0 * k3) - factor * (k4 + y * (2.0 * k5 + y * 3.0 * k6))) / bottom;
    for (int spoke = 0; spoke < kSpokes; ++spoke) {
      const auto [sine, cosine] = portable::sine_cosine(spoke * (2.0 * portable::kPi / kSpokes));
      const double a = r * cosine;
      const double b = r * sine;
      const double aa = factor + 2.0 * a * a * d_factor + 2.0 * p1 * b + 6.0 * p2 * a;
      const double ab = 2.0 * a * b * d_factor + 2.0 * p1 * a + 2.0 * p2 * b;
      const double bb = factor + 2.0 * b * b * d_factor + 6.0 * p1 * b + 2.0 * p2 * a;
      if (!(aa * bb - ab * ab > 0.0)) return true;
    }
  }
  return false;
}

double corner_radius(const View& view) {
  const double a = std::max(view.principal.x, 1.0 - view.principal.x) / view.focal.x;
  const double b = std::max(view.principal.y, 1.0 - view.principal.y) / view.focal.y;
  return std::sqrt(a * a + b * b);
}

}  // namespace

std::string limit_distortion(View& view) {
  if (view.distortion == Distortion::kNone) return {};
  const bool fisheye = view.distortion == Distortion::kFisheye;
  const double most = fisheye ? portable::kPi : 100.0;
  const double step = most / 20000.0;
  view.limit = step;
  while (view.limit < most) {
    const double next = view.limit + step;
    if (!fisheye && !(radial_divisor(view.coefficients, next) > 0.0)) break;
    if (!((fisheye ? fisheye_slope(view.coefficients, next) : radial_slope(view.coefficients, next)) > 0.0))
      break;
    view.limit = next;
  }
  if (fisheye) {
    const double y = view.limit * view.limit;
    const auto& k = view.coefficients;
    const double reach = view.limit * (1.0 + y * (k[0] + y * (k[1] + y * (k[2] + y * k[3]))));
    // Corners past the image circle are usual; the picture's nearer sides are not.
    const double side = std::min({view.principal.x / view.focal.x, (1.0 - view.principal.x) / view.focal.x,
                                  view.principal.y / view.focal.y, (1.0 - view.principal.y) / view.focal.y});
    if (view.limit < most - 2.0 * step && reach < side) {
      return fmt::format("the fisheye model folds at {:.2f} degrees from its axis, within the picture",
                         view.limit * 180.0 / portable::kPi);
    }
    return {};
  }
  const auto [k1, k2, p1, p2, k3, k4, k5, k6] = view.coefficients;
  const double y = view.limit * view.limit;
  const double reach =
      view.limit * (1.0 + y * (k1 + y * (k2 + y * k3))) / (1.0 + y * (k4 + y * (k5 + y * k6)));
  if (reach < corner_radius(view)) {
    return fmt::format(
        "the distortion model folds at radius {:.4f} (tangent of the angle), which reaches only to {:.4f} of "
        "the "
        "picture's corner at {:.4f}",
        view.limit, reach, corner_radius(view));
  }
  // The least ideal radius whose radial part reaches the corner.
  double low = 0.0;
  double high = view.limit;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    const double z = middle * middle;
    const double there = middle * (1.0 + z * (k1 + z * (k2 + z * k3))) / (1.0 + z * (k4 + z * (k5 + z * k6)));
    (there < corner_radius(view) ? low : high) = middle;
  }
  if (turns_over(view.coefficients, high)) {
    return "the distortion model folds within the picture: p1 and p2 are too large";
  }
  return {};
}

void read_calibration(const std::filesystem::path& file, View& view) {
  try {
    const YAML::Node root = YAML::Load(read_yaml_text(file));
    if (!root.IsMap())
      throw InputError(fmt::format("{}: expected an OpenCV calibration file", file.string()));
    const double width = positive(root, file, "image_width");
    const double height = positive(root, file, "image_height");
    const std::vector<double> m = numbers(root, file, "camera_matrix");
    const YAML::Node matrix = root["camera_matrix"];
    if (m.size() != 9) refuse(file, matrix, "camera_matrix", "expected 3 x 3 numbers");
    const auto sides = [](double pixels, double side) { return std::abs(pixels) / side; };
    if (!(m[0] > 0.0 && m[4] > 0.0 && sides(m[0], width) <= kMostSides && sides(m[4], height) <= kMostSides &&
          sides(m[0], width) >= 1.0 / kMostSides && sides(m[4], height) >= 1.0 / kMostSides)) {
      refuse(file, matrix, "camera_matrix",
             "expected focal lengths above 0, from a thousandth to a thousand of the picture's sides");
    }
    if (sides(m[2], width) > kMostSides || sides(m[5], height) > kMostSides) {
      refuse(file, matrix, "camera_matrix",
             "expected a principal point within a thousand of the picture's sides");
    }
    const std::vector<double> c = numbers(root, file, "distortion_coefficients");
    const YAML::Node model = root["distortion_model"];
    const bool fisheye =
        model && (model.as<std::string>() == "fisheye" || model.as<std::string>() == "equidistant");
    if (fisheye ? c.size() != 4 : (c.size() != 4 && c.size() != 5 && c.size() != 8)) {
      refuse(file, root["distortion_coefficients"], "distortion_coefficients",
             fisheye ? "expected 4 numbers" : "expected 4, 5 or 8 numbers");
    }
    view.focal = {m[0] / width, m[4] / height};
    view.principal = {(m[2] + 0.5) / width, (m[5] + 0.5) / height};
    view.coefficients = {};
    std::copy(c.begin(), c.end(), view.coefficients.begin());
    view.distortion = fisheye ? Distortion::kFisheye : Distortion::kRadialTangential;
    const std::string wrong = limit_distortion(view);
    if (!wrong.empty()) refuse(file, root["distortion_coefficients"], "distortion_coefficients", wrong);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

}  // namespace cupola
