// What is plugged into a V4L2 device: sockets that take video signals have timings, or no signal.
// SPDX-License-Identifier: MIT
#pragma once

#include <optional>
#include <variant>

#include "hal/camera/v4l2_node.h"

namespace cupola {

struct V4l2Signal {
  double rate = 0.0;  // frames a second, from the signal's timings; 0: the input does not say
};

// Sets the device to the signal that its input has.
std::variant<V4l2Signal, CameraTrouble> settle_input(const V4l2Node& node) noexcept;
// Why there is no signal, if there is none. Does not wait: for the frame path.
std::optional<CameraTrouble> missing_signal(const V4l2Node& node) noexcept;

}  // namespace cupola
