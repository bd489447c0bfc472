// The definition of the warp: plain loops over the table, for 8 and 16 bits a sample and any kind of pixel.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstring>
#include <type_traits>

#include "pipeline/warp/light.h"
#include "pipeline/warp/tile_kernel.h"

namespace cupola {
namespace {

int signed_byte(std::uint8_t byte) {
  return static_cast<std::int8_t>(byte);
}

int pair_weight(const WeightLine* high_and_low, int at) {
  return signed_byte(high_and_low[0].bytes[at]) * 128 + signed_byte(high_and_low[1].bytes[at]);
}

template <class Pixel>
inline constexpr int kChannels = 3;
template <>
inline constexpr int kChannels<Luma> = 1;
template <>
inline constexpr int kChannels<Chroma> = 2;

void put(Xrgb& pixel, const std::array<unsigned, 3>& rgb) {
  pixel = kBlackXrgb | rgb[0] << 16 | rgb[1] << 8 | rgb[2];
}
void put(Rgb16& pixel, const std::array<unsigned, 3>& rgb) {
  pixel = {static_cast<std::uint16_t>(rgb[0]), static_cast<std::uint16_t>(rgb[1]),
           static_cast<std::uint16_t>(rgb[2]), 0};
}
void put(Luma& pixel, const std::array<unsigned, 1>& y) {
  pixel = static_cast<Luma>(y[0]);
}
void put(Chroma& pixel, const std::array<unsigned, 2>& uv) {
  pixel = {static_cast<std::uint16_t>(uv[0]), static_cast<std::uint16_t>(uv[1])};
}

// What a texel counts for.
struct AsItIs {
  int operator()(int texel) const { return texel; }
};
struct LightOf8 {
  int operator()(int texel) const { return kLightOfSrgb8.words[static_cast<std::size_t>(texel)]; }
};
struct LightOf16 {
  const std::uint16_t* table = light_tables().light_of_srgb16.data();
  int operator()(int texel) const { return table[texel]; }
};

template <class Pixel, class Texel, class Value = AsItIs>
class BlockSum {
  static constexpr bool kWide = sizeof(Texel) == 2;

 public:
  // |weights| sum to at most 3 * 2^17, samples of 16 bits are below 2^16: hence 64 bits there.
  using Sum = std::conditional_t<kWide || std::is_same_v<Pixel, Rgb16>, std::int64_t, std::int32_t>;

  BlockSum(const Block& block, std::span<const ViewTexels> views) : block_(block), views_(views) {}

  const WeightLine* add(const Window& window, const WeightLine* line) {
    switch (block_.kind) {
      case BlockKind::kNarrow8:
        return add_narrow(window, line, 1, [](const WeightLine* l, int at) { return l->bytes[at] + 0; });
      case BlockKind::kSigned8:
        return add_narrow(window, line, 1, [](const WeightLine* l, int at) { return l->bytes[at] - kBias8; });
      case BlockKind::kNarrow16:
        return add_narrow(window, line, 2, pair_weight);
      case BlockKind::kWide16:
        for (int at = 0; at < kWindowSide * kWindowSide; ++at) {
          add_texel(window, window.start[0], at, pair_weight(line, at));
        }
        return line + 2;
    }
    return line;
  }

  Pixel pixel(int i) const {
    if ((block_.covered >> i & 1) == 0) return kBlack<Pixel>;
    std::array<unsigned, kCount> samples{};
    for (int channel = 0; channel < kCount; ++channel) {
      samples[channel] = kFine ? fine(sum_[i][channel]) : rounded(sum_[i][channel]);
    }
    Pixel pixel;
    put(pixel, samples);
    return pixel;
  }

 private:
  static constexpr int kCount = kChannels<Pixel>;
  static constexpr bool kFine = kCount < 3;

  unsigned fine(Sum sum) const {
    const Sum value = sum >> (block_.bits - kFineBits + (kWide ? 8 : 0));
    return static_cast<unsigned>(std::clamp<Sum>(value, 0, kWide ? kMostWideFine : kMostFine));
  }
  unsigned rounded(Sum sum) const {
    const Sum value = (sum + (Sum{1} << (block_.bits - 1))) >> block_.bits;
    return static_cast<unsigned>(std::clamp<Sum>(value, 0, std::is_same_v<Pixel, Rgb16> ? 65535 : 255));
  }

  // `at`: 8 * row + column within the window.
  void add_texel(const Window& window, int pixel, int at, int weight) {
    const ViewTexels& view = views_[window.view];
    for (int channel = 0; channel < kCount; ++channel) {
      const std::uint8_t* row = view.window(channel, window.x, window.y) + at / kWindowSide * view.stride;
      const std::uint8_t* bytes = row + view.column(at % kWindowSide) * view.step;
      Texel texel{};  // which need not lie at a multiple of its size
      std::memcpy(&texel, bytes, sizeof(texel));
      sum_[pixel][channel] += static_cast<Sum>(weight) * value_(texel);
    }
  }

  template <class Weight>
  const WeightLine* add_narrow(const Window& window, const WeightLine* line, int lines_a_row,
                               Weight&& weight) {
    for (int row = 0; row < window.rows; ++row, line += lines_a_row) {
      for (int pixel = 0; pixel < kPixelsInBlock; ++pixel) {
        for (int k = 0; k < kPatchWidth; ++k) {
          add_texel(window, pixel, window.start[pixel] + row * kWindowSide + k,
                    weight(line, pixel * kPatchWidth + k));
        }
      }
    }
    return line;
  }

  const Block& block_;
  std::span<const ViewTexels> views_;
  [[no_unique_address]] Value value_;
  std::array<std::array<Sum, kCount>, kPixelsInBlock> sum_{};
};

template <class Texel, class Value = AsItIs, class Pixel>
void run_tile(const WarpTable& table, const Tile& tile, std::span<const TileImage<Pixel>> images) noexcept {
  for (const TileImage<Pixel>& image : images) {
    const Window* window = table.windows.data() + tile.first_window;
    const WeightLine* line = table.lines.data() + tile.first_line;
    for (const Block& block : std::span(table.blocks).subspan(tile.first_block, tile.block_count)) {
      BlockSum<Pixel, Texel, Value> sum(block, image.views);
      for (std::uint32_t i = 0; i < block.window_count; ++i) line = sum.add(*window++, line);
      for (int i = 0; i < kPixelsInBlock; ++i) {
        const int column = i % kBlockSide;
        image.block(
            block.at)[i / kBlockSide * image.stride + (image.across ? kBlockSide - 1 - column : column)] =
            sum.pixel(i);
      }
    }
  }
}

}  // namespace

void run_tile_scalar(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Xrgb>> images) noexcept {
  run_tile<std::uint8_t>(table, tile, images);
}

void run_wide_scalar(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Rgb16>> images) noexcept {
  run_tile<std::uint16_t>(table, tile, images);
}

void run_linear_scalar(const WarpTable& table, const Tile& tile,
                       std::span<const TileImage<Rgb16>> images) noexcept {
  run_tile<std::uint8_t, LightOf8>(table, tile, images);
}

void run_wide_linear_scalar(const WarpTable& table, const Tile& tile,
                            std::span<const TileImage<Rgb16>> images) noexcept {
  run_tile<std::uint16_t, LightOf16>(table, tile, images);
}

void run_luma_scalar(const WarpTable& table, const Tile& tile,
                     std::span<const TileImage<Luma>> images) noexcept {
  run_tile<std::uint8_t>(table, tile, images);
}

void run_chroma_scalar(const WarpTable& table, const Tile& tile,
                       std::span<const TileImage<Chroma>> images) noexcept {
  run_tile<std::uint8_t>(table, tile, images);
}

void run_wide_luma_scalar(const WarpTable& table, const Tile& tile,
                          std::span<const TileImage<Luma>> images) noexcept {
  run_tile<std::uint16_t>(table, tile, images);
}

void run_wide_chroma_scalar(const WarpTable& table, const Tile& tile,
                            std::span<const TileImage<Chroma>> images) noexcept {
  run_tile<std::uint16_t>(table, tile, images);
}

}  // namespace cupola
