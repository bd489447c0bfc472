// Executes a warp table, a band of tiles a task: blocks into a stage that stays in the cache, whole rows from
// there into the frame.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_warp.h"

#include <algorithm>
#include <array>
#include <atomic>
#include <cstring>
#include <vector>

#include "pipeline/warp/row_store.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

// Views smaller than a window are copied into one of its size; the table never weighs what lies beyond.
class SmallViews {
 public:
  explicit SmallViews(const WarpTable& table) : padded_(table.views.size()) {
    for (std::size_t i = 0; i < table.views.size(); ++i) {
      if (!(table.needed[i].size == table.views[i])) {
        padded_[i] = ImageBuffer(PixelFormat::kRgbPlanar16, table.views[i]);  // room for 8 bits a sample too
      }
    }
  }

  // `face`, or its padded copy.
  Image padded(std::size_t i, const Image& face) {
    if (padded_[i].empty()) return face;
    Image copy = as_const(padded_[i].pixels());
    copy.format = face.format;
    for (int channel = 0; channel < 3; ++channel) {
      for (int y = 0; y < face.size.height; ++y) {
        std::memcpy(padded_[i].pixels().planes[channel].row(y), face.planes[channel].row(y),
                    static_cast<std::size_t>(face.size.width) * sample_bytes(face.format));
      }
    }
    return copy;
  }

 private:
  std::vector<ImageBuffer> padded_;
};

// A face of size `size` as a reflection of the frame sees it.
ViewTexels mirrored(const Image& face, const Reflection::Partner& partner) {
  ViewTexels texels;
  const std::ptrdiff_t step = sample_bytes(face.format);
  texels.across = partner.flip_u ? -step : step;
  texels.flip = partner.flip_u ? 0x07070707 : 0;
  const int x = partner.flip_u ? face.size.width - kWindowSide : 0;
  const int y = partner.flip_v ? face.size.height - 1 : 0;
  for (int channel = 0; channel < 3; ++channel) {
    const std::ptrdiff_t stride = face.planes[channel].stride;
    texels.origin[channel] = reinterpret_cast<const std::uint8_t*>(face.planes[channel].row(y)) + x * step;
    texels.stride[channel] = partner.flip_v ? -stride : stride;
  }
  return texels;
}

// The pixels of a band of tiles: its rows of the frame, and where the frame is symmetric from top to bottom
// those that mirror them.
template <class Pixel>
class Stage {
 public:
  explicit Stage(const WarpTable& table)
      : left_(table.left),
        stride_(table.reflections.front().across ? table.frame.width - 2 * table.left
                                                 : table.tiles_across * kTileWidth),
        pixels_(static_cast<std::size_t>(stride_) * kTileHeight * (table.reflections.front().down ? 2 : 1)) {}

  // Row `row` of the band, at frame column 0.
  Pixel* row(int row, bool mirrored) {
    return pixels_.data() + (row + (mirrored ? kTileHeight : 0)) * stride_ - left_;
  }
  std::ptrdiff_t stride() const { return stride_; }

 private:
  int left_;
  std::ptrdiff_t stride_;
  std::vector<Pixel> pixels_;
};

template <class Pixel>
Pixel black() {
  if constexpr (std::is_same_v<Pixel, Xrgb>) return kBlackXrgb;
  return {};
}

template <class Pixel>
class BandRun {
 public:
  BandRun(const WarpTable& table, TileKernel<Pixel> kernel, RowStore<Pixel> rows, int threads)
      : table_(table), kernel_(kernel), rows_(rows), free_(threads) {
    for (int i = 0; i < threads; ++i) stages_.emplace_back(table);
  }

  // Band `band` of the frame; `views` has the faces as each reflection sees them.
  void run(int band, std::span<const std::array<ViewTexels, kMostViews>> views, const MutableImage& frame) {
    Stage<Pixel>& stage = stages_[static_cast<std::size_t>(take())];
    for (int column = 0; column < table_.tiles_across; ++column) warp_tile(band, column, views, stage);
    for (const bool mirrored : {true, false}) {
      if (!mirrored || table_.reflections.front().down) store(band, mirrored, frame, stage);
    }
    rows_.finish();
    free(stage);
  }

 private:
  void warp_tile(int band, int column, std::span<const std::array<ViewTexels, kMostViews>> views,
                 Stage<Pixel>& stage) const {
    const Tile& tile = table_.tiles[static_cast<std::size_t>(band * table_.tiles_across + column)];
    const int x = table_.left + column * kTileWidth;
    std::array<TileImage<Pixel>, 4> images;
    const std::size_t count = table_.reflections.size();
    for (std::size_t i = 0; i < count; ++i) {
      const Reflection& reflection = table_.reflections[i];
      images[i] = {views[i],
                   stage.row(0, reflection.down) + (reflection.across ? table_.frame.width - 1 - x : x),
                   stage.stride(), reflection.across};
      if (tile.full == 0) blacken(images[i]);
    }
    kernel_(table_, tile, std::span(images).first(count));
  }

  static void blacken(const TileImage<Pixel>& image) {
    for (int row = 0; row < kTileHeight; ++row) {
      Pixel* first = image.corner + row * image.stride - (image.across ? kTileWidth - 1 : 0);
      std::fill_n(first, kTileWidth, black<Pixel>());
    }
  }

  void store(int band, bool mirrored, const MutableImage& frame, Stage<Pixel>& stage) const {
    for (int row = 0; row < kTileHeight; ++row) {
      const int y = table_.top + band * kTileHeight + row;
      if (y < 0 || y >= frame.size.height) continue;
      rows_.store(stage.row(row, mirrored), frame.size.width, frame, 0,
                  mirrored ? frame.size.height - 1 - y : y);
    }
  }

  // At most as many bands are under way as there are stages.
  int take() {
    for (std::size_t i = 0;; i = (i + 1) % free_.size()) {
      if (!free_[i].taken.exchange(true, std::memory_order_acquire)) return static_cast<int>(i);
    }
  }
  void free(const Stage<Pixel>& stage) {
    free_[static_cast<std::size_t>(&stage - stages_.data())].taken.store(false, std::memory_order_release);
  }

  struct Flag {
    std::atomic<bool> taken{false};
  };

  const WarpTable& table_;
  TileKernel<Pixel> kernel_;
  RowStore<Pixel> rows_;
  std::vector<Stage<Pixel>> stages_;
  std::vector<Flag> free_;
};

class TableWarp final : public FrameWarp {
 public:
  TableWarp(const WarpTable& table, Cpu cpu, WorkerPool& pool)
      : table_(table),
        pool_(pool),
        small_(table),
        narrow_(table, tile_kernel(cpu), row_store(cpu), pool.threads()),
        wide_(table, run_tile_wide, {store_row_wide, finish_rows_scalar}, pool.threads()) {}

  std::span<const NeededRegion> needed() const override { return table_.needed; }
  std::size_t table_bytes() const override { return table_.bytes(); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    std::array<Image, kMostViews> padded;
    for (std::size_t i = 0; i < faces.size(); ++i) padded[i] = small_.padded(i, faces[i]);
    std::array<std::array<ViewTexels, kMostViews>, 4> views;
    for (std::size_t i = 0; i < table_.reflections.size(); ++i) {
      for (std::size_t view = 0; view < faces.size(); ++view) {
        const Reflection::Partner& partner = table_.reflections[i].views[view];
        views[i][view] = mirrored(padded[partner.view], partner);
      }
    }
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    pool_.run(table_.tiles_down, [&](int band) {
      if (wide) {
        wide_.run(band, views, frame);
      } else {
        narrow_.run(band, views, frame);
      }
    });
  }

 private:
  const WarpTable& table_;
  WorkerPool& pool_;
  SmallViews small_;
  BandRun<Xrgb> narrow_;
  BandRun<Rgb16> wide_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_table_warp(const WarpTable& table, Cpu cpu, WorkerPool& pool) {
  return std::make_unique<TableWarp>(table, cpu, pool);
}

}  // namespace cupola
