// Words written on the sphere in strokes, upright and unmirrored as seen from its centre.
// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "pipeline/optics/vector.h"
#include "pipeline/source/direction_cells.h"

namespace cupola {

struct Label {
  std::string text;  // 0-9 A-Z + - and * for the degree sign; others are blank
  Vec3 centre;       // unit direction of the word's middle
  Vec3 up;           // need not be at a right angle to `centre`
  double height;     // of a capital, radians
  double stroke;     // width, radians
};

// At an azimuth (clockwise from the front) and an elevation, upright; degrees.
Label upright_label(std::string text, double azimuth_deg, double elevation_deg, double height_deg);

class Lettering {
 public:
  static constexpr double kFar = 1.0;  // radians: no stroke is near

  Lettering() = default;
  explicit Lettering(std::span<const Label> labels);

  // Radians from `d` to the nearest stroke's edge, negative within it; exact within `kMargin`, else kFar.
  static constexpr double kMargin = 0.006;
  double distance(const Vec3& d) const;

 private:
  struct Stroke {
    Vec2 from, along;       // on the tangent plane at the label's centre
    double inverse_square;  // 1 / |along|^2
  };
  struct Glyph {
    Vec3 centre, right, up;  // the label's
    double half_stroke;
    std::uint32_t first, last;  // strokes
  };
  std::vector<Stroke> strokes_;
  std::vector<Glyph> glyphs_;
  DirectionCells cells_;
};

}  // namespace cupola
