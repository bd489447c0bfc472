// A band of tiles at work: blocks into a stage that stays in the cache, whole rows from there into the frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <algorithm>
#include <array>
#include <atomic>
#include <optional>
#include <span>
#include <type_traits>
#include <vector>

#include "pipeline/frame/changed_cells.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/row_store.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {

// Pixels that are a texel's colour in other clothes; sums on their way to a conversion are not.
template <class Pixel>
inline constexpr bool kHasColour = std::is_same_v<Pixel, Xrgb> || std::is_same_v<Pixel, Rgb16>;

template <class Pixel>
Pixel pixel_of(const Colour& colour) {
  if constexpr (std::is_same_v<Pixel, Xrgb>) {
    return kBlackXrgb | Xrgb{colour.r} << 16 | Xrgb{colour.g} << 8 | Xrgb{colour.b};
  } else {
    return {colour.r, colour.g, colour.b, 0};
  }
}

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
  using PixelOf = Pixel (*)(const Colour& colour);

  // `pixel_of`: what the kernel makes of texels that all have that colour; null where pixels have none.
  BandTiles(const WarpTable& table, TileKernel<Pixel> kernel, PixelOf pixel_of)
      : table_(table), kernel_(kernel), pixel_of_(pixel_of) {
    const auto& [across, down, partners] = table.reflections.front();
    shared_ = (across && table.frame.width % 2 == 1) || (down && table.frame.height % 2 == 1);
  }

  // Band `band` of the frame onto the stage, but for tiles that show nothing of what is known to have
  // changed.
  WarpWork warp(int band, const ReflectedViews& views, const FaceKnowledge& known,
                Stage<Pixel>& stage) const {
    return warp(band, views, known.even, stage, [&](std::size_t tile) {
      return known.changed.empty() ? ~0U : images_changed(table_.tiles[tile], known.changed);
    });
  }

  // The same of what `wanted` gives by the tile's index, bit i for reflection i: all of them or none where
  // images share a middle row or column.
  template <class Wanted>
  WarpWork warp(int band, const ReflectedViews& views, std::span<const EvenCells> even, Stage<Pixel>& stage,
                const Wanted& wanted) const {
    WarpWork work;
    for (int column = 0; column < table_.tiles_across; ++column) {
      const auto tile = static_cast<std::size_t>(band * table_.tiles_across + column);
      warp_tile(band, column, views, even, wanted(tile), stage, work);
    }
    return work;
  }

  bool images_share() const { return shared_; }
  // Bit v: reflection `image` of a tile reads view v.
  unsigned views_read(std::size_t tile, std::size_t image) const {
    unsigned views = 0;
    visit_reach(table_.tiles[tile], table_.reflections[image], [&](std::size_t view, int, int, int, int) {
      views |= 1U << view;
      return true;
    });
    return views;
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
  void warp_tile(int band, int column, const ReflectedViews& views, std::span<const EvenCells> even,
                 unsigned wanted, Stage<Pixel>& stage, WarpWork& work) const {
    const Tile& tile = table_.tiles[static_cast<std::size_t>(band * table_.tiles_across + column)];
    const int x = table_.left + column * kTileWidth;
    std::array<TileImage<Pixel>, 4> images;
    std::size_t count = 0;
    const std::array<std::optional<Colour>, 4> colours = only_colours(tile, even, wanted);
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      const bool empty = tile.block_count == 0;
      if (empty) ++work.outside;
      if ((wanted >> i & 1) == 0) {
        if (!empty) ++work.skipped;
        continue;
      }
      const auto& [across, down, partners] = table_.reflections[i];
      const int first = across ? table_.frame.width - 1 - x : x;
      const TileImage<Pixel> image{views[i], stage.row(0, down) + first, stage.stride(), across};
      if (tile.full == 0) blacken(image);
      const int left = across ? first - (kTileWidth - 1) : first;
      stage.done(down).push_back({std::max(left, 0), std::min(left + kTileWidth, table_.frame.width)});
      if (empty) continue;
      if constexpr (kHasColour<Pixel>) {
        if (colours[i]) {
          fill(tile, image, pixel_of_(*colours[i]));
          ++work.even;
          continue;
        }
      }
      ++work.pieces;
      images[count++] = image;
    }
    if (count > 0) kernel_(table_, tile, std::span(images).first(count));
  }

  // Calls visit(view, x0, y0, x1, y1) for the rectangles of the faces that a tile's reflection looks at,
  // until one call gives false; gives what the last one gave.
  template <class Visit>
  bool visit_reach(const Tile& tile, const Reflection& reflection, Visit&& visit) const {
    for (const Reach& reach : std::span(table_.reaches).subspan(tile.first_reach, tile.reach_count)) {
      const auto [view, flip_u, flip_v] = reflection.views[reach.view];
      const Size size = table_.views[view];
      const int x0 = flip_u ? size.width - reach.x1 : reach.x0;
      const int y0 = flip_v ? size.height - reach.y1 : reach.y0;
      if (!visit(view, x0, y0, x0 + reach.x1 - reach.x0, y0 + reach.y1 - reach.y0)) return false;
    }
    return true;
  }

  // For each of the `wanted` reflections the colour of all texels that it weighs, if they have one. The
  // weights of a pixel sum to exactly 2^bits, those of texels beside the needed ones are 0: so its sum is
  // 2^bits times the colour, and rounding gives the colour again.
  std::array<std::optional<Colour>, 4> only_colours(const Tile& tile, std::span<const EvenCells> even,
                                                    unsigned wanted) const {
    std::array<std::optional<Colour>, 4> colours;
    if (even.empty()) return colours;
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      if ((wanted >> i & 1) == 0) continue;
      std::optional<Colour> one;
      const bool agreed =
          visit_reach(tile, table_.reflections[i], [&](std::size_t view, int x0, int y0, int x1, int y1) {
            return even[view].agree(x0, y0, x1, y1, one);
          });
      if (agreed) colours[i] = one;
      if (shared_ && !colours[i]) return {};
    }
    return colours;
  }

  // What the kernel would write where all that it sums is one colour.
  void fill(const Tile& tile, const TileImage<Pixel>& image, Pixel pixel) const {
    if (tile.full != 0) {
      fill_all(image, pixel);
      return;
    }
    for (const Block& block : std::span(table_.blocks).subspan(tile.first_block, tile.block_count)) {
      Pixel* corner = image.block(block.at);
      for (int i = 0; i < kPixelsInBlock; ++i) {
        const int column = i % kBlockSide;
        if ((block.covered >> i & 1) == 0) continue;
        corner[i / kBlockSide * image.stride + (image.across ? kBlockSide - 1 - column : column)] = pixel;
      }
    }
  }

  // Bit i: reflection i shows a texel that changed.
  unsigned images_changed(const Tile& tile, std::span<const ChangedCells> changed) const {
    unsigned images = 0;
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      const bool stands =
          visit_reach(tile, table_.reflections[i], [&](std::size_t view, int x0, int y0, int x1, int y1) {
            return !changed[view].touches(x0, y0, x1, y1);
          });
      if (!stands) images |= 1U << i;
    }
    return shared_ && images != 0 ? ~0U : images;
  }

  static void blacken(const TileImage<Pixel>& image) { fill_all(image, kBlack<Pixel>); }
  static void fill_all(const TileImage<Pixel>& image, Pixel pixel) {
    for (int row = 0; row < kTileHeight; ++row) {
      Pixel* first = image.corner + row * image.stride - (image.across ? kTileWidth - 1 : 0);
      std::fill_n(first, kTileWidth, pixel);
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
  PixelOf pixel_of_;
  bool shared_ = false;  // a middle row or column is in two images, and which one is written last matters
};

template <class Pixel>
class BandRun {
 public:
  BandRun(const WarpTable& table, TileKernel<Pixel> kernel, RowStore<Pixel> rows, int threads,
          typename BandTiles<Pixel>::PixelOf by = pixel_of<Pixel>)
      : tiles_(table, kernel, by), rows_(rows), stages_(threads, [&] { return Stage<Pixel>(table); }) {}

  // Band `band` of the frame; tiles that show nothing of what is known to have changed are left as they are.
  WarpWork run(int band, const ReflectedViews& views, const FaceKnowledge& known, const MutableImage& frame) {
    WarpWork work;
    stages_.with_one([&](Stage<Pixel>& stage) {
      work = tiles_.warp(band, views, known, stage);
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
