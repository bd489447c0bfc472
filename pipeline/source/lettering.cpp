// Words written on the sphere in strokes, upright and unmirrored as seen from its centre.
// SPDX-License-Identifier: MIT
#include "pipeline/source/lettering.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "pipeline/portable/portable_math.h"

namespace cupola {
namespace {

constexpr double kCapital = 9.0;  // grid units
constexpr double kAdvance = 8.5;

// Strokes separated by '/'; each a line through points "xy" of a grid 6 wide and 9 high, y up. '~' makes it a
// curve: the points control it and its ends touch the first and the last.
constexpr std::string_view glyph_strokes(char c) {
  switch (c) {
    case '0':
      return "~30 60 69 09 00 30";
    case '1':
      return "17 39 30";
    case '2':
      return "~07 09 69 65 00/00 60";
    case '3':
      return "~07 09 59 55 25/~25 65 60 00 02";
    case '4':
      return "40 49 03 63";
    case '5':
      return "59 19 05/~05 26 66 60 00 02";
    case '6':
      return "~58 09 00 60 65 05 03";
    case '7':
      return "09 69 20";
    case '8':
      return "~35 55 59 19 15 35/~35 65 60 00 05 35";
    case '9':
      return "~11 60 69 09 04 64 66";
    case '*':
      return "~29 49 46 16 19 29";
    case '+':
      return "14 54/36 32";
    case '-':
      return "14 54";
    case 'A':
      return "00 39 60/13 53";
    case 'B':
      return "00 09/09 29/~29 59 55 25/05 25/~25 65 60 20/00 20";
    case 'C':
      return "~67 69 09 00 60 62";
    case 'D':
      return "00 09 29/~29 69 60 20/00 20";
    case 'E':
      return "69 09 00 60/05 45";
    case 'F':
      return "69 09 00/05 45";
    case 'G':
      return "~67 69 09 00 60 64/64 34";
    case 'H':
      return "00 09/60 69/05 65";
    case 'I':
      return "30 39";
    case 'J':
      return "~49 40 00 03";
    case 'K':
      return "00 09/69 03/25 60";
    case 'L':
      return "09 00 60";
    case 'M':
      return "00 09 34 69 60";
    case 'N':
      return "00 09 60 69";
    case 'O':
      return "~30 60 69 09 00 30";
    case 'P':
      return "00 09 39/~39 69 64 34/04 34";
    case 'Q':
      return "~30 60 69 09 00 30/42 60";
    case 'R':
      return "00 09 39/~39 69 64 34/04 34/34 60";
    case 'S':
      return "~67 69 09 05 64 60 00 02";
    case 'T':
      return "09 69/39 30";
    case 'U':
      return "~09 00 60 69";
    case 'V':
      return "09 30 69";
    case 'W':
      return "09 20 36 40 69";
    case 'X':
      return "00 69/09 60";
    case 'Y':
      return "09 35 69/35 30";
    case 'Z':
      return "09 69 00 60";
    default:
      return "";
  }
}

// Chaikin's corner cutting, the ends kept.
std::vector<Vec2> rounded(const std::vector<Vec2>& line) {
  std::vector<Vec2> cut{line.front()};
  for (std::size_t i = 0; i + 1 < line.size(); ++i) {
    cut.push_back(0.75 * line[i] + 0.25 * line[i + 1]);
    cut.push_back(0.25 * line[i] + 0.75 * line[i + 1]);
  }
  cut.push_back(line.back());
  return cut;
}

std::vector<std::vector<Vec2>> glyph_lines(char c) {
  std::vector<std::vector<Vec2>> lines;
  std::string_view rest = glyph_strokes(c);
  while (!rest.empty()) {
    std::string_view stroke = rest.substr(0, rest.find('/'));
    rest.remove_prefix(std::min(rest.size(), stroke.size() + 1));
    const bool curved = stroke.front() == '~';
    if (curved) stroke.remove_prefix(1);
    std::vector<Vec2> line;
    for (std::size_t i = 0; i + 1 < stroke.size(); i += 3) {
      line.push_back({static_cast<double>(stroke[i] - '0'), static_cast<double>(stroke[i + 1] - '0')});
    }
    if (curved) line = rounded(rounded(line));
    lines.push_back(std::move(line));
  }
  return lines;
}

}  // namespace

Label upright_label(std::string text, double azimuth_deg, double elevation_deg, double height_deg) {
  const double azimuth = portable::radians(azimuth_deg), elevation = portable::radians(elevation_deg);
  const Vec3 centre{std::cos(elevation) * std::sin(azimuth), std::sin(elevation),
                    -std::cos(elevation) * std::cos(azimuth)};
  const double height = portable::radians(height_deg);
  return {std::move(text), centre, {0.0, 1.0, 0.0}, height, height * 0.12};
}

Lettering::Lettering(std::span<const Label> labels) {
  std::vector<Cone> cones;
  for (const Label& label : labels) {
    const Vec3 right = glm::normalize(glm::cross(label.centre, label.up));
    const Vec3 up = glm::cross(right, label.centre);
    const double unit = label.height / kCapital;
    const double width = kAdvance * static_cast<double>(label.text.size()) - (kAdvance - 6.0);
    for (std::size_t c = 0; c < label.text.size(); ++c) {
      const Vec2 corner{kAdvance * static_cast<double>(c) - 0.5 * width, -0.5 * kCapital};
      const auto first = static_cast<std::uint32_t>(strokes_.size());
      for (const auto& line : glyph_lines(label.text[c])) {
        for (std::size_t i = 0; i + 1 < line.size(); ++i) {
          const Vec2 from = unit * (corner + line[i]), along = unit * (line[i + 1] - line[i]);
          if (along != Vec2{0.0}) strokes_.push_back({from, along, 1.0 / glm::dot(along, along)});
        }
      }
      const Vec2 middle = unit * (corner + Vec2{3.0, 4.5});
      glyphs_.push_back(
          {label.centre, right, up, 0.5 * label.stroke, first, static_cast<std::uint32_t>(strokes_.size())});
      cones.push_back({glm::normalize(label.centre + middle.x * right + middle.y * up),
                       unit * 5.5 + 0.5 * label.stroke + kMargin});
    }
  }
  cells_ = DirectionCells(cones, 48);
}

double Lettering::distance(const Vec3& d) const {
  double nearest = kFar;
  for (const std::uint32_t g : cells_.near(d)) {
    const Glyph& glyph = glyphs_[g];
    const double depth = glm::dot(d, glyph.centre);
    const Vec2 p{glm::dot(d, glyph.right) / depth, glm::dot(d, glyph.up) / depth};
    double square = 1e9;
    for (std::uint32_t s = glyph.first; s < glyph.last; ++s) {
      const Stroke& stroke = strokes_[s];
      const Vec2 offset = p - stroke.from;
      const double share = std::clamp(glm::dot(offset, stroke.along) * stroke.inverse_square, 0.0, 1.0);
      const Vec2 across = offset - share * stroke.along;
      square = std::min(square, glm::dot(across, across));
    }
    nearest = std::min(nearest, std::sqrt(square) - glyph.half_stroke);
  }
  return nearest < kMargin ? nearest : kFar;
}

}  // namespace cupola
