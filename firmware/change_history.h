// What changed in the faces over the last frames, so that a buffer that holds an older frame can be brought
// up to date.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <span>
#include <vector>

#include "pipeline/frame/changed_cells.h"

namespace cupola {

// Allocates when made only.
class ChangeHistory {
 public:
  static constexpr int kFrames = 8;

  explicit ChangeHistory(std::span<const Size> faces);

  // Faces were fetched that differ from those before in `changed`; none: anything may have.
  void fetched(std::span<const ChangedCells> changed);
  // What was fetched goes into a buffer that holds the frame made `age` frames ago (1: the last one; 0: it
  // holds anything). Gives what differs, a face each; none: all of it.
  std::span<const ChangedCells> take(int age);

 private:
  struct Frame {
    bool all = true;
    std::vector<ChangedCells> faces;
  };

  Frame pending_;                      // fetched since the last take()
  std::array<Frame, kFrames> frames_;  // a ring; frames_[newest_] is the last taken
  std::size_t newest_ = 0;
  std::vector<ChangedCells> sum_;
};

}  // namespace cupola
