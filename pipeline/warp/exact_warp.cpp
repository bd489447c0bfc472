// The reference as a method: every pixel from the formulas, rounded once.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/sample_store.h"
#include "pipeline/warp/slow_warp.h"

namespace cupola {
namespace {

class ExactWarp final : public FrameWarp {
 public:
  ExactWarp(const Rig& rig, WorkerPool& pool) : rig_(rig), filter_(rig_), pool_(pool) {
    for (const View& view : rig.views) needed_.push_back(NeededRegion::all(view.size));
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override { return 0; }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const int bytes = sample_bytes(faces.front().format);
    const double most = bytes == 2 ? 65535.0 : 255.0;
    pool_.run(rig_.frame.size.height, [&](int y) {
      for (int x = 0; x < rig_.frame.size.width; ++x) {
        const auto rgb = filter_(faces, x, y);
        store_pixel(frame, x, y, bytes, round_sample(rgb[0], most), round_sample(rgb[1], most),
                    round_sample(rgb[2], most));
      }
    });
  }

 private:
  const Rig rig_;
  const UnroundedFilter filter_;  // borrows rig_
  WorkerPool& pool_;
  std::vector<NeededRegion> needed_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_exact_warp(const Rig& rig, WorkerPool& pool) {
  return std::make_unique<ExactWarp>(rig, pool);
}

}  // namespace cupola
