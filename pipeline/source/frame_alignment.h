// Free-running cameras brought to capture at once: each but the first is told to take a little longer or
// shorter over its frames.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <optional>
#include <vector>

#include "pipeline/source/rig_sync.h"

namespace cupola {

// The mathematics are in docs/hardware.md. One thread; does not allocate after construction.
class FrameAlignment {
 public:
  // `period` is what a frame takes as the cameras are set, above 0.
  FrameAlignment(std::size_t cameras, std::chrono::nanoseconds period);

  // What is measured of camera `camera`, from 1 on, at `now`. What a frame of it is to take from now on,
  // where that is something else than before.
  std::optional<std::chrono::nanoseconds> look(std::size_t camera, const SyncOffset& measured,
                                               std::chrono::nanoseconds now) noexcept;

 private:
  struct Camera {
    std::chrono::nanoseconds next{0};  // when it is looked at again
    double longer = 0.0;               // of the period, as a share of it
    std::chrono::nanoseconds told{0};
  };
  std::chrono::nanoseconds period_;
  std::vector<Camera> cameras_;
};

}  // namespace cupola
