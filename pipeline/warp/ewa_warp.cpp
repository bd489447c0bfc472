// Executes a warp table.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_warp.h"

#include <array>
#include <cstring>
#include <vector>

#include "pipeline/warp/tile_kernel.h"
#include "pipeline/warp/tile_store.h"

namespace cupola {
namespace {

constexpr std::size_t kMostViews = 6;

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

  ViewTexels texels(std::size_t i, const Image& face) {
    ViewTexels view;
    for (int channel = 0; channel < 3; ++channel) {
      const Plane<const std::byte>& from = face.planes[channel];
      view.plane[channel] = reinterpret_cast<const std::uint8_t*>(from.data);
      view.stride[channel] = from.stride;
      if (padded_[i].empty()) continue;
      const Plane<std::byte>& to = padded_[i].pixels().planes[channel];
      for (int y = 0; y < face.size.height; ++y) {
        std::memcpy(to.row(y), from.row(y),
                    static_cast<std::size_t>(face.size.width) * sample_bytes(face.format));
      }
      view.plane[channel] = reinterpret_cast<const std::uint8_t*>(to.data);
      view.stride[channel] = to.stride;
    }
    return view;
  }

 private:
  std::vector<ImageBuffer> padded_;
};

class TableWarp final : public FrameWarp {
 public:
  TableWarp(const WarpTable& table, Cpu cpu, WorkerPool& pool)
      : table_(table), kernel_(tile_kernel(cpu)), pool_(pool), small_(table) {}

  std::span<const NeededRegion> needed() const override { return table_.needed; }
  std::size_t table_bytes() const override { return table_.bytes(); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    std::array<ViewTexels, kMostViews> texels;
    for (std::size_t i = 0; i < faces.size(); ++i) texels[i] = small_.texels(i, faces[i]);
    const std::span<const ViewTexels> views(texels.data(), faces.size());
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    pool_.run(table_.tile_count(), [&](int tile) {
      const int x = tile % table_.tiles_across * kTileSide;
      const int y = tile / table_.tiles_across * kTileSide;
      if (wide) {
        TilePixels<std::uint16_t> pixels;
        run_tile_wide(table_, tile, views, pixels);
        store_tile(pixels, x, y, frame);
      } else {
        TilePixels<std::uint8_t> pixels;
        kernel_(table_, tile, views, pixels);
        store_tile(pixels, x, y, frame);
      }
    });
  }

 private:
  const WarpTable& table_;
  TileKernel kernel_;
  WorkerPool& pool_;
  SmallViews small_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_table_warp(const WarpTable& table, Cpu cpu, WorkerPool& pool) {
  return std::make_unique<TableWarp>(table, cpu, pool);
}

}  // namespace cupola
