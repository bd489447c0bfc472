// The faces scaled small, for whoever looks on from elsewhere: of one face a few rows a frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

#include "firmware/frame_maker.h"
#include "firmware/preview.h"

namespace cupola {

class FacePreviews {
 public:
  static constexpr int kLongestSide = 200;  // pixels
  static constexpr std::size_t kMost = 8;   // views; of those beyond there is none

  // The loop's, after the flip. Takes the next rows of the face whose turn it is among those that are asked
  // for; the bytes written.
  std::int64_t copy(const FrameMaker& show, std::chrono::nanoseconds flip) noexcept;

  // Anybody else's. View `view` < kMost.
  Preview& of(std::size_t view) { return previews_[view]; }

 private:
  struct FacePreview : Preview {
    FacePreview() : Preview({kLongestSide, kLongestSide}, kLongestSide) {}
  };
  std::array<FacePreview, kMost> previews_;
  std::size_t turn_ = 0;
};

}  // namespace cupola
