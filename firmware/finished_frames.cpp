// Only the format changes.
// SPDX-License-Identifier: MIT
#include "firmware/finished_frames.h"

#include <algorithm>

namespace cupola {
namespace {

constexpr int kRows = 16;  // a task

class FinishedFrames final : public FrameWarp {
 public:
  FinishedFrames(Size size, WorkerPool& pool) : needed_(NeededRegion::all(size)), pool_(pool) {}

  std::span<const NeededRegion> needed() const override { return {&needed_, 1}; }
  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    const int height = frame.size.height;
    pool_.run((height + kRows - 1) / kRows, [&](int task) {
      const int first = task * kRows;
      const Size rows{frame.size.width, std::min(kRows, height - first)};
      convert(part_of(faces[0], 0, first, rows), part_of(frame, 0, first, rows));
    });
  }
  std::size_t table_bytes() const override { return 0; }

 private:
  NeededRegion needed_;
  WorkerPool& pool_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_finished_frames(Size size, WorkerPool& pool) {
  return std::make_unique<FinishedFrames>(size, pool);
}

}  // namespace cupola
