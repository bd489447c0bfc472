// One face after the other, so that a frame never pays for two.
// SPDX-License-Identifier: MIT
#include "firmware/face_previews.h"

namespace cupola {

std::int64_t FacePreviews::copy(const FrameMaker& show, std::chrono::nanoseconds flip) noexcept {
  for (std::size_t i = 0; i < kMost; ++i) {
    const std::size_t view = (turn_ + i) % kMost;
    if (!previews_[view].wants(flip)) continue;
    turn_ = (view + 1) % kMost;
    return previews_[view].copy(show.face(view), flip);
  }
  return 0;
}

}  // namespace cupola
