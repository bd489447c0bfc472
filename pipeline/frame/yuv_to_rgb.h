// Pictures of luma and chroma planes as planar RGB: what videos hold.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/frame/row_range.h"
#include "pipeline/frame/yuv_colour.h"

namespace cupola {

// Where a chroma sample lies between the luma samples it is for.
enum class Siting : std::uint8_t { kBetween, kOnFirst };

struct PlanarVideo {
  Size size;
  int bits = 8;            // a sample, 8 to 16; above 8 in little-endian pairs of bytes
  bool colour = true;      // false: luma only
  int chroma_shift_x = 0;  // 0 or 1; 1: a chroma sample for two columns
  int chroma_shift_y = 0;
  Siting siting_x = Siting::kBetween;
  Siting siting_y = Siting::kBetween;
  bool full_range = false;
  LumaWeights weights;

  int chroma_width() const { return (size.width + chroma_shift_x) >> chroma_shift_x; }
  int chroma_height() const { return (size.height + chroma_shift_y) >> chroma_shift_y; }
  int bytes_per_sample() const { return bits > 8 ? 2 : 1; }
  friend bool operator==(const PlanarVideo&, const PlanarVideo&) = default;
};

// Chroma is interpolated linearly at its siting, and rounded only once, with the RGB result, of 8 bits or,
// above 8, of 16: nearest, within 0.51 steps of the real numbers. One thread at a time.
class YuvToRgb {
 public:
  explicit YuvToRgb(const PlanarVideo& video);

  const PlanarVideo& video() const { return video_; }
  // The rows of chroma that the rows `rows` need: one more above and below to interpolate from.
  RowRange chroma_rows(RowRange rows) const;
  // Fills the rows `rows`, which lie within the picture, of `into`, which has the video's size and any planar
  // format. `planes` begin with the row rows.first, those of chroma with chroma_rows(rows).first. Does not
  // allocate.
  void convert(const std::array<Plane<const std::byte>, 3>& planes, RowRange rows, const MutableImage& into);

 private:
  template <class Sample>
  void convert_rows(const std::array<Plane<const std::byte>, 3>& planes, RowRange rows,
                    const MutableImage& into);
  template <class Sample>
  void interpolate_chroma(const Plane<const std::byte>& plane, std::size_t p, int y, RowRange chroma_rows);

  PlanarVideo video_;
  std::vector<std::int32_t> column_;                       // one chroma row between the rows, times 4
  std::array<std::vector<std::int32_t>, 2> interpolated_;  // Cb and Cr for each pixel of a row, times 16
  ImageBuffer row_;                                        // one row of RGB
};

}  // namespace cupola
