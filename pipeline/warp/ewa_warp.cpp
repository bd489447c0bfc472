// Executes a warp table, a band of tiles a task.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_warp.h"

#include <array>
#include <atomic>
#include <cassert>
#include <cstring>
#include <optional>
#include <vector>

#include "pipeline/warp/band_run.h"
#include "pipeline/warp/light.h"
#include "pipeline/warp/mirrored_texels.h"

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

ViewTexels mirrored(const Image& face, const Reflection::Partner& partner) {
  const Plane<const std::byte>& first = face.planes[0];
  ViewTexels texels = mirrored_texels({reinterpret_cast<const std::uint8_t*>(first.data), first.stride},
                                      face.size, sample_bytes(face.format), partner);
  for (int channel = 0; channel < 3; ++channel) {
    assert(face.planes[channel].stride == first.stride);
    texels.channel[channel] = ViewTexels::bytes_between(first.data, face.planes[channel].data);
  }
  return texels;
}

// What kernels make of texels of one colour, in linear light.
Rgb16 light_of_colour8(const Colour& colour) {
  const auto& light = kLightOfSrgb8.words;
  return {light[colour.r], light[colour.g], light[colour.b], 0};
}
Rgb16 light_of_colour16(const Colour& colour) {
  const auto& light = light_tables().light_of_srgb16;
  return {light[colour.r], light[colour.g], light[colour.b], 0};
}

class TableWarp final : public FrameWarp {
 public:
  TableWarp(const WarpTable& table, Cpu cpu, WorkerPool& pool, const SampleSettings& samples)
      : table_(table), pool_(pool), small_(table), linear_(samples.linear_light) {
    if (linear_) {
      light8_.emplace(table, linear_kernel(cpu), wide_row_store(cpu, Narrowing::kFromLight), pool.threads(),
                      light_of_colour8);
      wide_.emplace(
          table, wide_linear_kernel(cpu),
          wide_row_store(cpu, samples.dither ? Narrowing::kFromLightDithered : Narrowing::kFromLight),
          pool.threads(), light_of_colour16);
    } else {
      narrow_.emplace(table, tile_kernel(cpu), row_store(cpu), pool.threads());
      wide_.emplace(table, wide_kernel(cpu),
                    wide_row_store(cpu, samples.dither ? Narrowing::kDithered : Narrowing::kRounded),
                    pool.threads());
    }
  }

  std::span<const NeededRegion> needed() const override { return table_.needed; }
  std::size_t table_bytes() const override { return table_.bytes(); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    warp_known(faces, {}, frame);
  }

  WarpWork warp_known(std::span<const Image> faces, const FaceKnowledge& known,
                      const MutableImage& frame) noexcept override {
    const ReflectedViews views = reflect(faces);
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    std::atomic<std::int64_t> pieces{0};
    std::atomic<std::int64_t> skipped{0};
    std::atomic<std::int64_t> even{0};
    std::atomic<std::int64_t> outside{0};
    pool_.run(table_.tiles_down, [&](int band) {
      const WarpWork work = wide      ? wide_->run(band, views, known, frame)
                            : linear_ ? light8_->run(band, views, known, frame)
                                      : narrow_->run(band, views, known, frame);
      pieces.fetch_add(work.pieces, std::memory_order_relaxed);
      skipped.fetch_add(work.skipped, std::memory_order_relaxed);
      even.fetch_add(work.even, std::memory_order_relaxed);
      outside.fetch_add(work.outside, std::memory_order_relaxed);
    });
    return {pieces.load(), skipped.load(), even.load(), outside.load()};
  }

 private:
  ReflectedViews reflect(std::span<const Image> faces) {
    std::array<Image, kMostViews> padded;
    for (std::size_t i = 0; i < faces.size(); ++i) padded[i] = small_.padded(i, faces[i]);
    return reflected_views<Image>(table_, std::span(padded).first(faces.size()), mirrored);
  }

  const WarpTable& table_;
  WorkerPool& pool_;
  SmallViews small_;
  bool linear_;
  // For faces of 8 bits one of the first two.
  std::optional<BandRun<Xrgb>> narrow_;
  std::optional<BandRun<Rgb16>> light8_;
  std::optional<BandRun<Rgb16>> wide_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_table_warp(const WarpTable& table, Cpu cpu, WorkerPool& pool,
                                           const SampleSettings& samples) {
  return std::make_unique<TableWarp>(table, cpu, pool, samples);
}

}  // namespace cupola
