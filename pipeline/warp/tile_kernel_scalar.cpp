// The definition of the warp: plain loops over the table, for 8 and 16 bits a sample.
// SPDX-License-Identifier: MIT
#include <algorithm>

#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

int signed_byte(std::uint8_t byte) {
  return static_cast<std::int8_t>(byte);
}

// |weight| * sample summed over a footprint: below 2^13 * 2^16 * 2 for 16 bits, hence 64 bits there.
template <class Sample>
using Sum = std::conditional_t<sizeof(Sample) == 1, std::int32_t, std::int64_t>;

template <class Sample>
Sample rounded(Sum<Sample> sum, int bits) {
  const Sum<Sample> value = (sum + (Sum<Sample>{1} << (bits - 1))) >> bits;
  return static_cast<Sample>(std::clamp<Sum<Sample>>(value, 0, static_cast<Sample>(~Sample{0})));
}

template <class Sample>
const Sample* texel_row(const ViewTexels& view, int channel, int x, int y) {
  return reinterpret_cast<const Sample*>(view.plane[channel] + y * view.stride[channel]) + x;
}

template <class Sample>
class TileRun {
 public:
  TileRun(const WarpTable& table, std::span<const ViewTexels> views) : table_(table), views_(views) {}

  void block(const Block& block, int channel, Sample* out) const {
    std::array<Sum<Sample>, kPixelsInBlock> sum{};
    const WeightLine* line = table_.lines.data() + block.first_line;
    for (std::uint32_t i = 0; i < block.window_count; ++i) {
      const Window& window = table_.windows[block.first_window + i];
      if (block.kind == BlockKind::kWide16) {
        line = add_wide(window, channel, line, sum);
      } else {
        line = add_narrow(window, block.kind, channel, line, sum);
      }
    }
    for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
      out[pixel / kBlockSide * kTileSide + pixel % kBlockSide] = rounded<Sample>(sum[pixel], block.bits);
    }
  }

 private:
  const WeightLine* add_narrow(const Window& window, BlockKind kind, int channel, const WeightLine* line,
                               std::array<Sum<Sample>, kPixelsInBlock>& sum) const {
    for (int row = 0; row < window.rows; ++row) {
      for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
        const int start = window.start[pixel];
        const Sample* texel = texel_row<Sample>(views_[window.view], channel, window.x + start % kWindowSide,
                                                window.y + start / kWindowSide + row);
        for (int k = 0; k < kPatchWidth; ++k) {
          const int at = pixel * kPatchWidth + k;
          const int weight = kind == BlockKind::kNarrow8
                                 ? line[0].bytes[at]
                                 : signed_byte(line[0].bytes[at]) * 128 + signed_byte(line[1].bytes[at]);
          sum[pixel] += static_cast<Sum<Sample>>(weight) * texel[k];
        }
      }
      line += kind == BlockKind::kNarrow8 ? 1 : 2;
    }
    return line;
  }

  const WeightLine* add_wide(const Window& window, int channel, const WeightLine* line,
                             std::array<Sum<Sample>, kPixelsInBlock>& sum) const {
    for (int row = 0; row < kWindowSide; ++row) {
      const Sample* texel = texel_row<Sample>(views_[window.view], channel, window.x, window.y + row);
      for (int k = 0; k < kWindowSide; ++k) {
        const int at = row * kWindowSide + k;
        const int weight = signed_byte(line[0].bytes[at]) * 128 + signed_byte(line[1].bytes[at]);
        sum[window.pixel] += static_cast<Sum<Sample>>(weight) * texel[k];
      }
    }
    return line + 2;
  }

  const WarpTable& table_;
  std::span<const ViewTexels> views_;
};

template <class Sample>
void run_tile(const WarpTable& table, int tile, std::span<const ViewTexels> views,
              TilePixels<Sample>& pixels) noexcept {
  const TileRun<Sample> run(table, views);
  for (int i = 0; i < kBlocksInTile; ++i) {
    const Block& block = table.blocks[static_cast<std::size_t>(tile) * kBlocksInTile + i];
    for (int channel = 0; channel < 3; ++channel) {
      Sample* out = pixels.channel[channel].data() + first_pixel(i);
      if (block.kind == BlockKind::kEmpty) {
        for (int row = 0; row < kBlockSide; ++row) std::fill_n(out + row * kTileSide, kBlockSide, Sample{0});
      } else {
        run.block(block, channel, out);
      }
    }
  }
}

}  // namespace

void run_tile_scalar(const WarpTable& table, int tile, std::span<const ViewTexels> views,
                     TilePixels<std::uint8_t>& pixels) noexcept {
  run_tile(table, tile, views, pixels);
}

void run_tile_wide(const WarpTable& table, int tile, std::span<const ViewTexels> views,
                   TilePixels<std::uint16_t>& pixels) noexcept {
  run_tile(table, tile, views, pixels);
}

}  // namespace cupola
