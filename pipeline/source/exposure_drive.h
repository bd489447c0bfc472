// All cameras exposed alike, so that seams do not show who looks where it is brighter: one exposure and one
// gain for the rig, followed slowly.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

#include "pipeline/frame/native_image.h"
#include "pipeline/optics/view.h"

namespace cupola {

struct Exposure {
  double us = 8000.0;  // how long a row is exposed, microseconds
  double gain = 1.0;   // 1 is none
  friend bool operator==(const Exposure&, const Exposure&) = default;
};

struct ExposureLimits {
  double brightness = 0.45;  // what the pictures' mean is to be, as encoded; 0 black to 1 white
  double shortest_us = 100.0;
  double longest_us = 10000.0;
  double most_gain = 4.0;  // from 1
};

// The mathematics are in docs/hardware.md. One thread; after construction it allocates nothing. A call to
// look() reads a grid of one picture.
class ExposureDrive {
 public:
  // Begins at the longest exposure without gain. `looked_at`: of each view, the texels that count; empty:
  // none of it does.
  ExposureDrive(const ExposureLimits& limits, std::vector<TexelBox> looked_at);

  // A new set of faces, at `now`. Bit v of `seen`: view v shows its camera's picture of this set. True when
  // exposure() is another than before.
  bool look(std::span<const NativeImage> faces, unsigned seen, std::chrono::nanoseconds now) noexcept;
  const Exposure& exposure() const { return exposure_; }
  const ExposureLimits& limits() const { return limits_; }
  double brightness() const { return brightness_; }  // the last mean of all; 0 before there was one

 private:
  bool decide(std::chrono::nanoseconds now) noexcept;

  ExposureLimits limits_;
  std::vector<TexelBox> looked_at_;
  Exposure exposure_;
  double stops_;        // log2 of exposure times gain
  bool moving_ = true;  // not yet near enough since it was far off
  double brightness_ = 0.0;
  std::size_t next_ = 0;  // the view that is looked at next
  double sum_ = 0.0;      // of the views looked at in this round
  int count_ = 0;
  std::chrono::nanoseconds begins_{0};  // the next round: what was set has come through by then
};

}  // namespace cupola
