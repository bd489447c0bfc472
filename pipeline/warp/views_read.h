// Which views each tile of a table reads, and what of it need be done where some of them changed.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstdint>
#include <vector>

#include "pipeline/warp/band_run.h"

namespace cupola {

// For each tile the views that each of its images reads.
using ViewsRead = std::vector<std::array<unsigned, 4>>;

template <class Pixel>
ViewsRead views_read(const WarpTable& table, const BandTiles<Pixel>& tiles) {
  ViewsRead read(table.tiles.size());
  for (std::size_t tile = 0; tile < read.size(); ++tile) {
    for (std::size_t image = 0; image < table.reflections.size(); ++image)
      read[tile][image] = tiles.views_read(tile, image);
  }
  return read;
}

// The images of a tile that read one of the `changed` views, or all where images share pixels.
inline unsigned wanted_images(const std::array<unsigned, 4>& read, unsigned changed, bool share) {
  if (changed == ~0U) return ~0U;
  unsigned images = 0;
  for (unsigned image = 0; image < 4; ++image) images |= (read[image] & changed) != 0 ? 1U << image : 0U;
  return share && images != 0 ? ~0U : images;
}

// Counts of bands on several threads.
class WorkSum {
 public:
  void add(const WarpWork& work) {
    pieces_.fetch_add(work.pieces, std::memory_order_relaxed);
    skipped_.fetch_add(work.skipped, std::memory_order_relaxed);
    outside_.fetch_add(work.outside, std::memory_order_relaxed);
  }
  WarpWork total() const { return {pieces_.load(), skipped_.load(), 0, outside_.load()}; }

 private:
  std::atomic<std::int64_t> pieces_{0}, skipped_{0}, outside_{0};
};

}  // namespace cupola
