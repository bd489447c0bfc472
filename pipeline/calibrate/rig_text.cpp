// Lines of keys that go, and lines that come after the view's name.
// SPDX-License-Identifier: MIT
#include "pipeline/calibrate/rig_text.h"

#include <fmt/format.h>
#include <toml++/toml.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <set>
#include <sstream>
#include <vector>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

// A number that is 0 but for rounding is 0.
double tidy(double value) {
  return std::abs(value) < 5e-10 ? 0.0 : value;
}

std::string vector(std::string_view key, const Vec3& d, int digits) {
  return fmt::format("{} = [{:.{}f}, {:.{}f}, {:.{}f}]\n", key, tidy(d.x), digits, tidy(d.y), digits,
                     tidy(d.z), digits);
}

// A text in a TOML file.
std::string quoted(const std::string& text) {
  if (text.find_first_of("\"\\") == std::string::npos) return "\"" + text + "\"";
  std::ostringstream stream;
  stream << toml::value<std::string>(text);
  return stream.str();
}

}  // namespace

std::string rewrite_views(const std::string& text, const std::filesystem::path& file,
                          std::span<const ViewKeys> views, const Mat3& world_from_lens) {
  const toml::table document = toml::parse(text, file.string());
  const bool level = document["views"].value_or(std::string_view("axis")) == "world";
  const Mat3 turn = level ? world_from_lens : Mat3{1.0};
  const toml::array* entries = document["view"].as_array();
  std::set<std::size_t> gone;                // lines, from 1
  std::map<std::size_t, std::string> after;  // of these
  std::map<std::size_t, std::string> taken;  // lines by the key that has them
  for (std::size_t v = 0; entries && v < views.size() && v < entries->size(); ++v) {
    const toml::table& entry = *entries->get(v)->as_table();
    const ViewKeys& keys = views[v];
    if (!keys.calibration && !keys.forward && !keys.position_m) continue;
    std::string added;
    if (keys.forward) added += vector("forward", turn * *keys.forward, 9) + vector("up", turn * keys.up, 9);
    if (keys.position_m) added += vector("position_m", turn * *keys.position_m, 4);
    if (keys.calibration) added += fmt::format("calibration = {}\n", quoted(*keys.calibration));
    for (const auto& [key, value] : entry) {
      const std::string name(key.str());
      const std::size_t first = key.source().begin.line;
      const std::size_t last = value.source().end.line;
      const bool pose = name == "forward" || name == "up";
      const bool lens = name == "calibration" || name == "fov_deg" || name == "fov_y_deg";
      const bool goes =
          (pose && keys.forward) || (lens && keys.calibration) || (name == "position_m" && keys.position_m);
      for (std::size_t line = first; line <= last; ++line) {
        if (entry.is_inline() || !taken.try_emplace(line, name).second) {
          throw InputError(
              fmt::format("{}:{}: view.{}: expected the views as tables [[view]], with every key "
                          "on lines of its own",
                          file.string(), line, v));
        }
        if (goes) gone.insert(line);
      }
      if (name == "name") after[last] = added;
    }
  }
  std::string result;
  std::istringstream lines(text);
  std::string line;
  for (std::size_t number = 1; std::getline(lines, line); ++number) {
    if (!gone.contains(number)) result += line + "\n";
    const auto added = after.find(number);
    if (added != after.end()) result += added->second;
  }
  return result;
}

}  // namespace cupola
