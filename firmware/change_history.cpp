// A ring of the last frames' changes.
// SPDX-License-Identifier: MIT
#include "firmware/change_history.h"

#include <utility>

namespace cupola {

ChangeHistory::ChangeHistory(std::span<const Size> faces) {
  for (const Size size : faces) sum_.emplace_back(size);
  pending_.faces = sum_;
  for (Frame& frame : frames_) frame.faces = sum_;
}

void ChangeHistory::fetched(std::span<const ChangedCells> changed) {
  if (changed.empty()) pending_.all = true;
  for (std::size_t i = 0; i < changed.size(); ++i) pending_.faces[i].add(changed[i]);
}

std::span<const ChangedCells> ChangeHistory::take(int age) {
  newest_ = (newest_ + 1) % frames_.size();
  std::swap(frames_[newest_], pending_);
  pending_.all = false;
  for (ChangedCells& face : pending_.faces) face.clear();
  if (age < 1 || age > kFrames) return {};
  for (ChangedCells& face : sum_) face.clear();
  for (int i = 0; i < age; ++i) {
    const Frame& frame = frames_[(newest_ + frames_.size() - static_cast<std::size_t>(i)) % frames_.size()];
    if (frame.all) return {};
    for (std::size_t face = 0; face < sum_.size(); ++face) sum_[face].add(frame.faces[face]);
  }
  return sum_;
}

}  // namespace cupola
