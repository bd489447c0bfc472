// First all samples from the faces, then all pixels from the samples, in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"
#include "pipeline/warp/two_pass_plan.h"

namespace cupola {
namespace {

// Samples of the first pass made in one go.
constexpr std::size_t kPortion = 4096;

class TwoPassWarp final : public FrameWarp {
 public:
  TwoPassWarp(const Rig& rig, WorkerPool& pool)
      : plan_(plan_two_pass(rig, pool)), between_(plan_.samples.size() * 3), pool_(pool) {
    for (const View& view : rig.views) needed_.push_back(NeededRegion::none(view.size));
    for (const TwoPassPlan::Sample& sample : plan_.samples) {
      NeededRegion& region = needed_[sample.view];
      region.include(sample.x, sample.y);
      for (int i = 1; i < sample.count; ++i) {
        region.include(sample.x + (sample.along_row ? i : 0), sample.y + (sample.along_row ? 0 : i));
      }
    }
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override {
    return plan_.samples.size() * sizeof(plan_.samples[0]) + plan_.starts.size() * sizeof(plan_.starts[0]) +
           plan_.runs.size() * sizeof(plan_.runs[0]) +
           (plan_.weights.size() + plan_.sample_weights.size()) * sizeof(plan_.weights[0]);
  }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    const std::size_t portions = (plan_.samples.size() + kPortion - 1) / kPortion;
    pool_.run(static_cast<int>(portions), [&](int portion) {
      const std::size_t first = static_cast<std::size_t>(portion) * kPortion;
      const std::size_t last = std::min(first + kPortion, plan_.samples.size());
      for (std::size_t i = first; i < last; ++i) {
        if (wide) {
          make_sample<std::uint16_t>(faces, i);
        } else {
          make_sample<std::uint8_t>(faces, i);
        }
      }
    });
    pool_.run(frame.size.height, [&](int y) {
      for (int x = 0; x < frame.size.width; ++x) make_pixel(frame, x, y, wide);
    });
  }

 private:
  // Weights sum to 2^14 and texels are below 2^16: sums stay below 2^30. Samples of 8-bit faces are kept
  // times 256, up to 65,280.
  template <class Texel>
  void make_sample(std::span<const Image> faces, std::size_t index) noexcept {
    constexpr int kDown = sizeof(Texel) == 1 ? TwoPassPlan::kShift - 8 : TwoPassPlan::kShift;
    const TwoPassPlan::Sample& sample = plan_.samples[index];
    const std::uint16_t* weights = plan_.sample_weights.data() + sample.weight;
    const Image& face = faces[sample.view];
    for (int channel = 0; channel < 3; ++channel) {
      std::uint32_t sum = 1U << (kDown - 1);
      if (sample.along_row) {
        const Texel* texels = face.samples<Texel>(channel, sample.y) + sample.x;
        for (int k = 0; k < sample.count; ++k) sum += std::uint32_t{weights[k]} * texels[k];
      } else {
        for (int k = 0; k < sample.count; ++k) {
          sum += std::uint32_t{weights[k]} * face.samples<Texel>(channel, sample.y + k)[sample.x];
        }
      }
      between_[index * 3 + static_cast<std::size_t>(channel)] = static_cast<std::uint16_t>(sum >> kDown);
    }
  }

  void make_pixel(const MutableImage& frame, int x, int y, bool wide) const noexcept {
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(plan_.frame.width) +
                              static_cast<std::size_t>(x);
    const TwoPassPlan::Start& start = plan_.starts[pixel];
    const std::uint32_t end = plan_.starts[pixel + 1].run;
    if (start.run == end) {
      store_pixel(frame, x, y, 1, 0, 0, 0);
      return;
    }
    const int down = wide ? TwoPassPlan::kShift : TwoPassPlan::kShift + 8;
    std::array<std::uint32_t, 3> sums;
    sums.fill(1U << (down - 1));
    const std::uint16_t* weights = plan_.weights.data() + start.weight;
    for (std::uint32_t i = start.run; i < end; ++i) {
      const TwoPassPlan::Run& run = plan_.runs[i];
      const std::uint16_t* samples = between_.data() + std::size_t{run.first} * 3;
      for (std::uint32_t k = 0; k < run.count; ++k, samples += 3) {
        for (std::size_t channel = 0; channel < 3; ++channel) {
          sums[channel] += std::uint32_t{weights[k]} * samples[channel];
        }
      }
      weights += run.count;
    }
    store_pixel(frame, x, y, wide ? 2 : 1, sums[0] >> down, sums[1] >> down, sums[2] >> down);
  }

  TwoPassPlan plan_;
  std::vector<std::uint16_t> between_;
  std::vector<NeededRegion> needed_;
  WorkerPool& pool_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_two_pass_warp(const Rig& rig, WorkerPool& pool) {
  return std::make_unique<TwoPassWarp>(rig, pool);
}

}  // namespace cupola
