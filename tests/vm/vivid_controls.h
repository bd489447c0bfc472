// Controls of vivid's own, with which a test breaks its cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <array>
#include <string>
#include <variant>

#include "hal/camera/v4l2_controls.h"
#include "hal/camera/v4l2_devices.h"

namespace cupola {

inline std::string vivid_bus(int number) {
  return "platform:vivid-00" + std::to_string(number);
}

// Through a descriptor of its own, while somebody else streams.
inline void set_vivid(int number, const char* control, double value) {
  LinuxCalls calls;
  const auto opened = open_v4l2_device(calls, vivid_bus(number));
  ASSERT_TRUE(std::holds_alternative<V4l2Node>(opened)) << describe(std::get<CameraTrouble>(opened));
  const V4l2Node& node = std::get<V4l2Node>(opened);
  const std::array<CameraControl, 1> controls = {{{control, value}}};
  const auto trouble = set_controls(node, controls);
  EXPECT_FALSE(trouble) << control << ": " << describe(*trouble);
  calls.close(node.descriptor);
}

}  // namespace cupola
