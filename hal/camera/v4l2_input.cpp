// DV timings and input status. Cameras with a sensor have neither.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_input.h"

#include <cerrno>

namespace cupola {

namespace {

bool selected_input(const V4l2Node& node, v4l2_input& input) noexcept {
  int index = 0;
  if (node.ask(VIDIOC_G_INPUT, &index) != 0) return false;
  input = {};
  input.index = static_cast<__u32>(index);
  return node.ask(VIDIOC_ENUMINPUT, &input) == 0;
}

// 0 and the timings; ENODATA or ENOTTY where the device cannot tell.
int query_timings(const V4l2Node& node, v4l2_dv_timings& timings) noexcept {
  timings = {};
  const int error = node.ask(VIDIOC_QUERY_DV_TIMINGS, &timings);
  return error == ERANGE ? ENOLCK : error;  // a signal that the device cannot take
}

double rate_of(const v4l2_bt_timings& bt) noexcept {
  const double width = static_cast<double>(V4L2_DV_BT_FRAME_WIDTH(&bt));
  const double height = static_cast<double>(V4L2_DV_BT_FRAME_HEIGHT(&bt));
  return width > 0.0 && height > 0.0 ? static_cast<double>(bt.pixelclock) / (width * height) : 0.0;
}

CameraTrouble no_signal(const v4l2_input& input) noexcept {
  const bool power = (input.status & V4L2_IN_ST_NO_POWER) == 0;
  return {CameraCause::kNoSignal, power ? "input without signal" : "input without power", 0};
}

constexpr __u32 kNothingThere = V4L2_IN_ST_NO_POWER | V4L2_IN_ST_NO_SIGNAL;

}  // namespace

std::variant<V4l2Signal, CameraTrouble> settle_input(const V4l2Node& node) noexcept {
  v4l2_input input;
  if (!selected_input(node, input)) return V4l2Signal{};
  if ((input.capabilities & V4L2_IN_CAP_DV_TIMINGS) == 0) {
    if ((input.status & kNothingThere) != 0) return no_signal(input);
    return V4l2Signal{};
  }
  v4l2_dv_timings timings;
  const int error = query_timings(node, timings);
  if (error == ENODATA || error == ENOTTY) return V4l2Signal{};
  if (error != 0) return refused("VIDIOC_QUERY_DV_TIMINGS", error);
  V4l2Signal signal;
  if (timings.type == V4L2_DV_BT_656_1120) signal.rate = rate_of(timings.bt);
  if (const int refusal = node.ask(VIDIOC_S_DV_TIMINGS, &timings)) {
    return refused("VIDIOC_S_DV_TIMINGS", refusal);
  }
  return signal;
}

std::optional<CameraTrouble> missing_signal(const V4l2Node& node) noexcept {
  v4l2_input input;
  if (!selected_input(node, input)) return std::nullopt;
  if ((input.capabilities & V4L2_IN_CAP_DV_TIMINGS) != 0) {
    v4l2_dv_timings timings;
    const CameraTrouble trouble = refused("VIDIOC_QUERY_DV_TIMINGS", query_timings(node, timings));
    if (trouble.cause == CameraCause::kNoSignal) return trouble;
  } else if ((input.status & kNothingThere) != 0) {
    return no_signal(input);
  }
  return std::nullopt;
}

}  // namespace cupola
