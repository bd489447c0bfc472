// From a method's name to a warp made ready.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/frame_warp.h"

#include <algorithm>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/slow_warp.h"
#include "pipeline/warp/table_build.h"

namespace cupola {
namespace {

// A table warp that owns its table.
class OwningTableWarp final : public FrameWarp {
 public:
  OwningTableWarp(WarpTable table, Cpu cpu, WorkerPool& pool, const SampleSettings& samples)
      : table_(std::move(table)), warp_(make_table_warp(table_, cpu, pool, samples)) {}

  std::span<const NeededRegion> needed() const override { return warp_->needed(); }
  std::size_t table_bytes() const override { return warp_->table_bytes(); }
  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    warp_->warp(faces, frame);
  }
  WarpWork warp_known(std::span<const Image> faces, const FaceKnowledge& known,
                      const MutableImage& frame) noexcept override {
    return warp_->warp_known(faces, known, frame);
  }

 private:
  WarpTable table_;
  std::unique_ptr<FrameWarp> warp_;
};

}  // namespace

WarpWork FrameWarp::warp_known(std::span<const Image> faces, const FaceKnowledge& known,
                               const MutableImage& frame) noexcept {
  const auto stands = [](const ChangedCells& changed) { return changed.count() == 0; };
  if (!known.changed.empty() && std::ranges::all_of(known.changed, stands)) return {.skipped = 1};
  warp(faces, frame);
  return {.pieces = 1};
}

std::unique_ptr<FrameWarp> make_frame_warp(const Rig& rig, Method method, Cpu cpu, WorkerPool& pool,
                                           TableCache* cache) {
  switch (method) {
    case Method::kEwa:
      return std::make_unique<OwningTableWarp>(cache ? cache->table(rig, pool) : build_warp_table(rig, pool),
                                               cpu, pool, rig.samples);
    case Method::kEwaExact:
      return make_exact_warp(rig, pool);
    case Method::kEwaScan:
    case Method::kEwaScanInteger:
      return make_scan_warp(rig, method, pool);
    case Method::kEwaPyramid:
    case Method::kTrilinear:
      return make_pyramid_warp(rig, method, pool);
    case Method::kTwoPass:
      return make_two_pass_warp(rig, pool);
    case Method::kSummedArea:
      return make_summed_area_warp(rig, pool);
    case Method::kBilinear:
    case Method::kNearest:
      return make_point_warp(rig, method, pool);
  }
  return nullptr;
}

}  // namespace cupola
