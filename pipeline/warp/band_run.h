// A band of tiles at work: blocks into a stage that stays in the cache, whole rows from there into the frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <span>
#include <vector>

#include "pipeline/frame/changed_cells.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/row_store.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

// The faces as each of the table's reflections sees them.
using ReflectedViews = std::array<std::array<ViewTexels, kMostViews>, 4>;

// The pixels of a band of tiles: its rows of the frame, and where the frame is symmetric from top to bottom
// those that mirror them. One thread uses it at a time.
template <class Pixel>
class Stage {
 public:
  struct Columns {
    int first, last;
  };

  explicit Stage(const WarpTable& table)
      : left_(table.left),
        stride_(table.reflections.front().across ? table.frame.width - 2 * table.left
                                                 : table.tiles_across * kTileWidth),
        pixels_(static_cast<std::size_t>(stride_) * kTileHeight * (table.reflections.front().down ? 2 : 1)) {
    for (auto& columns : done_) columns.reserve(static_cast<std::size_t>(2 * table.tiles_across));
  }

  // Row `row` of the band, at frame column 0.
  Pixel* row(int row, bool mirrored) {
    return pixels_.data() + (row + (mirrored ? kTileHeight : 0)) * stride_ - left_;
  }
  std::ptrdiff_t stride() const { return stride_; }
  // Frame columns that hold pixels of this frame, of the band itself and of its mirror image.
  std::vector<Columns>& done(bool mirrored) { return done_[mirrored ? 1 : 0]; }

 private:
  int left_;
  std::ptrdiff_t stride_;
  std::vector<Pixel> pixels_;
  std::array<std::vector<Columns>, 2> done_;
};

// One of a few things of which every thread needs one at a time.
template <class Thing>
class PerThread {
 public:
  template <class Make>
  PerThread(int threads, Make&& make) : free_(static_cast<std::size_t>(threads)) {
    for (int i = 0; i < threads; ++i) things_.push_back(make());
  }

  // Calls use(thing) with one that nobody else has; at most as many calls at a time as there are threads.
  template <class Use>
  void with_one(Use&& use) {
    std::size_t i = 0;
    while (free_[i].taken.exchange(true, std::memory_order_acquire)) i = (i + 1) % free_.size();
    use(things_[i]);
    free_[i].taken.store(false, std::memory_order_release);
  }

 private:
  struct Flag {
    std::atomic<bool> taken{false};
  };
  std::vector<Thing> things_;
  std::vector<Flag> free_;
};

// The tiles of one table.
template <class Pixel>
class BandTiles {
 public:
  BandTiles(const WarpTable& table, TileKernel<Pixel> kernel) : table_(table), kernel_(kernel) {}

  // Band `band` of the frame onto the stage. With `changed`, one a view, tiles that none of it touches are
  // left out.
  WarpWork warp(int band, const ReflectedViews& views, std::span<const ChangedCells> changed,
                Stage<Pixel>& stage) const {
    WarpWork work;
    for (int column = 0; column < table_.tiles_across; ++column) {
      warp_tile(band, column, views, changed, stage, work);
    }
    return work;
  }

  // Calls put(x, y, count, row, mirrored) for every run of pixels on the stage, `row` and `mirrored` as
  // Stage::row() takes them, and empties the stage.
  template <class Put>
  void unload(int band, Stage<Pixel>& stage, Put&& put) const {
    for (const bool mirrored : {true, false}) {
      std::vector<typename Stage<Pixel>::Columns>& done = stage.done(mirrored);
      join(done);
      for (int row = 0; row < kTileHeight && !done.empty(); ++row) {
        const int y = table_.top + band * kTileHeight + row;
        if (y < 0 || y >= table_.frame.height) continue;
        for (const auto& columns : done) {
          put(columns.first, mirrored ? table_.frame.height - 1 - y : y, columns.last - columns.first, row,
              mirrored);
        }
      }
      done.clear();
    }
  }

 private:
  void warp_tile(int band, int column, const ReflectedViews& views, std::span<const ChangedCells> changed,
                 Stage<Pixel>& stage, WarpWork& work) const {
    const Tile& tile = table_.tiles[static_cast<std::size_t>(band * table_.tiles_across + column)];
    const int x = table_.left + column * kTileWidth;
    std::array<TileImage<Pixel>, 4> images;
    std::size_t count = 0;
    const unsigned wanted = changed.empty() ? ~0U : images_changed(tile, changed);
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      if ((wanted >> i & 1) == 0) {
        ++work.skipped;
        continue;
      }
      ++work.pieces;
      const auto& [across, down, partners] = table_.reflections[i];
      const int first = across ? table_.frame.width - 1 - x : x;
      images[count] = {views[i], stage.row(0, down) + first, stage.stride(), across};
      if (tile.full == 0) blacken(images[count]);
      const int left = across ? first - (kTileWidth - 1) : first;
      stage.done(down).push_back({std::max(left, 0), std::min(left + kTileWidth, table_.frame.width)});
      ++count;
    }
    if (count > 0) kernel_(table_, tile, std::span(images).first(count));
  }

  // Bit i: reflection i shows a texel that changed.
  unsigned images_changed(const Tile& tile, std::span<const ChangedCells> changed) const {
    unsigned images = 0;
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      for (const Reach& reach : std::span(table_.reaches).subspan(tile.first_reach, tile.reach_count)) {
        const auto [view, flip_u, flip_v] = table_.reflections[i].views[reach.view];
        const Size size = table_.views[view];
        const int x0 = flip_u ? size.width - reach.x1 : reach.x0;
        const int y0 = flip_v ? size.height - reach.y1 : reach.y0;
        if (changed[view].touches(x0, y0, x0 + reach.x1 - reach.x0, y0 + reach.y1 - reach.y0)) {
          images |= 1U << i;
        }
      }
    }
    // A middle row or column is in two images, and which one is written last matters.
    const auto& [across, down, partners] = table_.reflections.front();
    const bool shared = (across && table_.frame.width % 2 == 1) || (down && table_.frame.height % 2 == 1);
    return shared && images != 0 ? ~0U : images;
  }

  static void blacken(const TileImage<Pixel>& image) {
    for (int row = 0; row < kTileHeight; ++row) {
      Pixel* first = image.corner + row * image.stride - (image.across ? kTileWidth - 1 : 0);
      std::fill_n(first, kTileWidth, kBlack<Pixel>);
    }
  }

  // Neighbours become one, empty ones none.
  static void join(std::vector<typename Stage<Pixel>::Columns>& done) {
    std::sort(done.begin(), done.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    std::size_t kept = 0;
    for (const auto columns : done) {
      if (columns.first >= columns.last) continue;
      if (kept > 0 && columns.first <= done[kept - 1].last) {
        done[kept - 1].last = std::max(done[kept - 1].last, columns.last);
      } else {
        done[kept++] = columns;
      }
    }
    done.resize(kept, {0, 0});
  }

  const WarpTable& table_;
  TileKernel<Pixel> kernel_;
};

template <class Pixel>
class BandRun {
 public:
  BandRun(const WarpTable& table, TileKernel<Pixel> kernel, RowStore<Pixel> rows, int threads)
      : tiles_(table, kernel), rows_(rows), stages_(threads, [&] { return Stage<Pixel>(table); }) {}

  // Band `band` of the frame. With `changed`, one a view, tiles that none of it touches are left as they are.
  WarpWork run(int band, const ReflectedViews& views, std::span<const ChangedCells> changed,
               const MutableImage& frame) {
    WarpWork work;
    stages_.with_one([&](Stage<Pixel>& stage) {
      work = tiles_.warp(band, views, changed, stage);
      tiles_.unload(band, stage, [&](int x, int y, int count, int row, bool mirrored) {
        rows_.store(stage.row(row, mirrored) + x, count, frame, x, y);
      });
      rows_.finish();
    });
    return work;
  }

 private:
  BandTiles<Pixel> tiles_;
  RowStore<Pixel> rows_;
  PerThread<Stage<Pixel>> stages_;
};

}  // namespace cupola
