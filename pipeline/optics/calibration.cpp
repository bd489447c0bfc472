// Reading OpenCV calibration files and checking that their model is one-to-one over the picture.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/calibration.h"

#include <fmt/format.h>
#include <yaml-cpp/yaml.h>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <sstream>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/optics/portable_math.h"

namespace cupola {
namespace {

[[noreturn]] void refuse(const std::filesystem::path& file, const std::string& key,
                         const std::string& message) {
  throw InputError(fmt::format("{}: {}: {}", file.string(), key, message));
}

// OpenCV writes "%YAML:1.0", which no YAML reader but its own takes.
std::string read_yaml_text(const std::filesystem::path& file) {
  std::ifstream stream(file);
  std::stringstream text;
  text << stream.rdbuf();
  if (!stream || std::filesystem::is_directory(file)) {
    throw InputError(fmt::format("{}: cannot be read, expected an OpenCV calibration file", file.string()));
  }
  std::string all = text.str();
  if (all.starts_with("%YAML")) all.erase(0, all.find('\n'));
  return all;
}

std::vector<double> numbers(const YAML::Node& root, const std::filesystem::path& file,
                            const std::string& key) {
  const YAML::Node node = root[key];
  if (!node) refuse(file, key, "missing, expected an OpenCV matrix");
  const YAML::Node data = node.IsMap() ? node["data"] : node;
  if (!data || !data.IsSequence() || data.size() > 64)
    refuse(file, key, "expected an OpenCV matrix with data: [...]");
  std::vector<double> values;
  for (const YAML::Node& item : data) {
    values.push_back(item.as<double>());
    if (!std::isfinite(values.back())) refuse(file, key, "expected finite numbers");
  }
  return values;
}

double positive(const YAML::Node& root, const std::filesystem::path& file, const std::string& key) {
  const YAML::Node node = root[key];
  if (!node) refuse(file, key, "missing, expected a number of pixels");
  const auto value = node.as<double>();
  if (!(value >= 1.0 && value <= 65535.0)) refuse(file, key, "expected a number of pixels from 1 to 65535");
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
    if (m.size() != 9) refuse(file, "camera_matrix", "expected 3 x 3 numbers");
    if (!(m[0] > 0.0 && m[4] > 0.0)) refuse(file, "camera_matrix", "expected focal lengths above 0");
    const std::vector<double> c = numbers(root, file, "distortion_coefficients");
    const YAML::Node model = root["distortion_model"];
    const bool fisheye =
        model && (model.as<std::string>() == "fisheye" || model.as<std::string>() == "equidistant");
    if (fisheye ? c.size() != 4 : (c.size() != 4 && c.size() != 5 && c.size() != 8)) {
      refuse(file, "distortion_coefficients", fisheye ? "expected 4 numbers" : "expected 4, 5 or 8 numbers");
    }
    view.focal = {m[0] / width, m[4] / height};
    view.principal = {(m[2] + 0.5) / width, (m[5] + 0.5) / height};
    view.coefficients = {};
    std::copy(c.begin(), c.end(), view.coefficients.begin());
    view.distortion = fisheye ? Distortion::kFisheye : Distortion::kRadialTangential;
    const std::string wrong = limit_distortion(view);
    if (!wrong.empty()) refuse(file, "distortion_coefficients", wrong);
  } catch (const YAML::Exception& error) {
    throw InputError(fmt::format("{}:{}: {}", file.string(), error.mark.line + 1, error.msg));
  }
}

}  // namespace cupola
