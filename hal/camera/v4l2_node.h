// An open V4L2 device and how to ask it something.
// SPDX-License-Identifier: MIT
#pragma once

#include <linux/videodev2.h>

#include "hal/camera/camera.h"
#include "hal/camera/system_calls.h"

namespace cupola {

// Borrows the system calls and the descriptor.
struct V4l2Node {
  SystemCalls* calls = nullptr;
  int descriptor = -1;
  bool multi_planar = false;

  // 0, or errno. Interrupted calls are made again.
  int ask(unsigned long request, void* argument) const noexcept;
  v4l2_buf_type type() const noexcept {
    return multi_planar ? V4L2_BUF_TYPE_VIDEO_CAPTURE_MPLANE : V4L2_BUF_TYPE_VIDEO_CAPTURE;
  }
};

// The trouble that a call which failed with `error` means; `step` in static storage.
CameraTrouble refused(const char* step, int error) noexcept;

}  // namespace cupola
