// A cell's first needed texel gives the colour; the first other one ends the look.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/even_cells.h"

#include <algorithm>
#include <array>
#include <cstring>

namespace cupola {
namespace {

constexpr int kSide = ChangedCells::kSide;

// Whether `count` samples are all `value`, eight bytes at a time.
template <class Sample>
bool all_are(const Sample* samples, int count, Sample value) {
  constexpr int kStep = 8 / sizeof(Sample);
  const std::uint64_t eight = value * (~std::uint64_t{0} / static_cast<Sample>(~Sample{0}));
  std::uint64_t differ = 0;
  int i = 0;
  for (; i + kStep <= count; i += kStep) {
    std::uint64_t word;
    std::memcpy(&word, samples + i, 8);
    differ |= word ^ eight;
  }
  for (; i < count; ++i) differ |= static_cast<std::uint64_t>(samples[i] ^ value);
  return differ == 0;
}

}  // namespace

EvenCells::EvenCells(Size size)
    : size_(size),
      across_((size.width + kSide - 1) / kSide),
      down_((size.height + kSide - 1) / kSide),
      cells_(static_cast<std::size_t>(across_) * static_cast<std::size_t>(down_)) {}

template <class Sample>
EvenCells::Cell EvenCells::look_at(const Image& face, const NeededRegion& needed, int x0, int y0) const {
  const int y1 = std::min(y0 + kSide, size_.height);
  const auto span_of = [&](int y) {
    const RowSpan& row = needed.rows[static_cast<std::size_t>(y)];
    return RowSpan{std::max(row.first, x0), std::min(row.last, x0 + kSide)};
  };
  int first = y0;
  while (first < y1 && span_of(first).empty()) ++first;
  if (first == y1) return {Kind::kUnused, {}};
  std::array<Sample, 3> colour{};
  for (int plane = 0; plane < 3; ++plane) {
    colour[static_cast<std::size_t>(plane)] = face.samples<Sample>(plane, first)[span_of(first).first];
    for (int y = first; y < y1; ++y) {
      const RowSpan span = span_of(y);
      if (span.empty()) continue;
      const Sample* row = face.samples<Sample>(plane, y) + span.first;
      if (!all_are(row, span.last - span.first, colour[static_cast<std::size_t>(plane)])) return {};
    }
  }
  return {Kind::kEven, {colour[0], colour[1], colour[2]}};
}

void EvenCells::look(const Image& face, const NeededRegion& needed, const ChangedCells* changed) {
  const bool deep = face.format == PixelFormat::kRgbPlanar16;
  Cell* cell = cells_.data();
  for (int y = 0; y < size_.height; y += kSide) {
    for (int x = 0; x < size_.width; x += kSide, ++cell) {
      if (changed != nullptr && !changed->touches(x, y, x + 1, y + 1)) continue;
      *cell = deep ? look_at<std::uint16_t>(face, needed, x, y) : look_at<std::uint8_t>(face, needed, x, y);
    }
  }
}

bool EvenCells::agree(int x0, int y0, int x1, int y1, std::optional<Colour>& one) const {
  const int last_x = std::min(x1, size_.width);
  const int last_y = std::min(y1, size_.height);
  for (int y = std::max(y0, 0) / kSide; y * kSide < last_y; ++y) {
    for (int x = std::max(x0, 0) / kSide; x * kSide < last_x; ++x) {
      const Cell& cell = cells_[static_cast<std::size_t>(y * across_ + x)];
      if (cell.kind == Kind::kUnused) continue;
      if (cell.kind == Kind::kUneven || (one && !(*one == cell.colour))) return false;
      one = cell.colour;
    }
  }
  return true;
}

std::int64_t EvenCells::count() const {
  return std::count_if(cells_.begin(), cells_.end(),
                       [](const Cell& cell) { return cell.kind == Kind::kEven; });
}

}  // namespace cupola
