// Makes the levels, then sums every pixel's taps, in integers.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/pyramid_plan.h"
#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"

namespace cupola {
namespace {

class PyramidWarp final : public FrameWarp {
 public:
  PyramidWarp(PyramidPlan plan, WorkerPool& pool)
      : taps_(std::move(plan.taps)),
        views_(plan.shape.views()),
        pyramid_(plan.shape, texels_used(plan.shape, taps_)),
        pool_(pool) {}

  std::span<const NeededRegion> needed() const override { return pyramid_.needed(); }
  std::size_t table_bytes() const override { return taps_.bytes(); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    pyramid_.build(faces, pool_);
    const bool wide = faces.front().format == PixelFormat::kRgbPlanar16;
    pool_.run(frame.size.height, [&](int y) {
      for (int x = 0; x < frame.size.width; ++x) {
        if (wide) {
          put<std::uint16_t>(faces, frame, x, y);
        } else {
          put<std::uint8_t>(faces, frame, x, y);
        }
      }
    });
  }

 private:
  // Weights sum to 2^14 and samples are below 2^16, so that sums stay below 2^30. Levels of 8-bit faces are
  // times 256, up to 65,280, and so are their texels here.
  template <class Sample>
  void put(std::span<const Image> faces, const MutableImage& frame, int x, int y) const {
    constexpr int kFaceShift = sizeof(Sample) == 1 ? 8 : 0;
    constexpr int kShift = TapRuns::kShift + kFaceShift;
    const std::size_t pixel = static_cast<std::size_t>(y) * static_cast<std::size_t>(taps_.frame.width) +
                              static_cast<std::size_t>(x);
    const TapRuns::Start& start = taps_.starts[pixel];
    const std::uint32_t end = taps_.starts[pixel + 1].run;
    if (start.run == end) {
      store_pixel(frame, x, y, 1, 0, 0, 0);
      return;
    }
    std::uint32_t sums[3] = {1U << (kShift - 1), 1U << (kShift - 1), 1U << (kShift - 1)};
    const std::uint16_t* weights = taps_.weights.data() + start.weight;
    for (std::uint32_t i = start.run; i < end; ++i) {
      const TapRuns::Run& run = taps_.runs[i];
      if (run.image < views_) {
        add<Sample, kFaceShift>(faces[run.image], run, weights, sums);
      } else {
        add<std::uint16_t, 0>(pyramid_.image(run.image), run, weights, sums);
      }
      weights += run.count;
    }
    store_pixel(frame, x, y, sizeof(Sample), sums[0] >> kShift, sums[1] >> kShift, sums[2] >> kShift);
  }

  template <class Sample, int kLeft>
  static void add(const Image& image, const TapRuns::Run& run, const std::uint16_t* weights,
                  std::uint32_t (&sums)[3]) {
    for (int channel = 0; channel < 3; ++channel) {
      const Sample* samples = image.samples<Sample>(channel, run.y) + run.x;
      std::uint32_t sum = 0;
      for (int k = 0; k < run.count; ++k) sum += std::uint32_t{weights[k]} * samples[k];
      sums[channel] += sum << kLeft;
    }
  }

  TapRuns taps_;
  std::size_t views_;
  Pyramid pyramid_;
  WorkerPool& pool_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_pyramid_warp(const Rig& rig, Method method, WorkerPool& pool) {
  return std::make_unique<PyramidWarp>(
      method == Method::kTrilinear ? plan_trilinear(rig, pool) : plan_ewa_pyramid(rig, pool), pool);
}

}  // namespace cupola
