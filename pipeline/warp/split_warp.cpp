// Two warps, each of one half of the frame; nothing is copied.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "pipeline/frame/error.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {
namespace {

class SplitWarp final : public FrameWarp {
 public:
  SplitWarp(std::unique_ptr<FrameWarp> left, std::unique_ptr<FrameWarp> right, Size left_size,
            Size right_size)
      : left_(std::move(left)), right_(std::move(right)), left_size_(left_size), right_size_(right_size) {
    needed_.assign(left_->needed().begin(), left_->needed().end());
    for (std::size_t view = 0; view < needed_.size(); ++view) needed_[view].include(right_->needed()[view]);
  }

  std::span<const NeededRegion> needed() const override { return needed_; }
  std::size_t table_bytes() const override { return left_->table_bytes() + right_->table_bytes(); }

  void warp(std::span<const Image> faces, const MutableImage& frame) noexcept override {
    left_->warp(faces, part_of(frame, 0, 0, left_size_));
    right_->warp(faces, part_of(frame, left_size_.width, 0, right_size_));
  }
  WarpWork warp_known(std::span<const Image> faces, const FaceKnowledge& known,
                      const MutableImage& frame) noexcept override {
    WarpWork work = left_->warp_known(faces, known, part_of(frame, 0, 0, left_size_));
    work += right_->warp_known(faces, known, part_of(frame, left_size_.width, 0, right_size_));
    return work;
  }

 private:
  std::unique_ptr<FrameWarp> left_, right_;
  Size left_size_, right_size_;
  std::vector<NeededRegion> needed_;
};

}  // namespace

std::unique_ptr<FrameWarp> make_split_warp(const Rig& rig, Method left, Method right, Cpu cpu,
                                           WorkerPool& pool, TableCache* cache) {
  const FrameModel model = rig.frame.model;
  if ((model != FrameModel::kFisheye && model != FrameModel::kChromeBall) || rig.frame.size.width < 2) {
    throw InputError(
        fmt::format("{}: only a fisheye or a chrome ball can be split in two halves", rig.file.string()));
  }
  Rig left_rig = rig;
  Rig right_rig = rig;
  left_rig.frame.size.width = rig.frame.size.width / 2;
  right_rig.frame.size.width = rig.frame.size.width - left_rig.frame.size.width;
  right_rig.frame.center.x -= left_rig.frame.size.width;
  return std::make_unique<SplitWarp>(make_frame_warp(left_rig, left, cpu, pool, cache),
                                     make_frame_warp(right_rig, right, cpu, pool, cache), left_rig.frame.size,
                                     right_rig.frame.size);
}

}  // namespace cupola
