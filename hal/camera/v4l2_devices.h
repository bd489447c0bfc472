// Which V4L2 devices there are, and which of them a name means.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/camera/v4l2_node.h"

namespace cupola {

struct V4l2Device {
  std::string path;                       // /dev/video0
  std::string driver;                     // uvcvideo
  std::string card;                       // what the maker calls it
  std::string bus;                        // where it is plugged in: the same after every boot
  std::optional<CameraTrouble> unusable;  // why it is none of our cameras
};

// Every /dev/video that exists, those that are no cameras too.
std::vector<V4l2Device> list_v4l2_devices(SystemCalls& calls);

// Opens the first camera whose path, bus or card is `name`; any camera for "". Who gets it closes it.
std::variant<V4l2Node, CameraTrouble> open_v4l2_device(SystemCalls& calls, const std::string& name);

}  // namespace cupola
