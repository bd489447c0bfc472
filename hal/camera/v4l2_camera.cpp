// The stream: on, frame after frame, off. What is agreed before it lies in the files beside this one.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_camera.h"

#include <algorithm>
#include <cerrno>
#include <new>

#include "hal/camera/camera_planes.h"
#include "hal/camera/v4l2_controls.h"
#include "hal/camera/v4l2_devices.h"
#include "hal/camera/v4l2_input.h"

namespace cupola {

namespace {

constexpr int kMostEvents = 32;  // looked at in one poll

bool subscribe(const V4l2Node& node, __u32 type) noexcept {
  v4l2_event_subscription subscription{};
  subscription.type = type;
  return node.ask(VIDIOC_SUBSCRIBE_EVENT, &subscription) == 0;
}

}  // namespace

std::variant<CameraMode, CameraTrouble> V4l2Camera::start(const CameraSetup& setup) noexcept {
  stop();
  if (const auto trouble = set_up(setup)) {
    stop();
    return *trouble;
  }
  return layout_.mode;
}

std::optional<CameraTrouble> V4l2Camera::set_up(const CameraSetup& setup) {
  if (setup.buffers < 2 || setup.buffers > static_cast<int>(V4l2Buffers::kMost)) {
    return CameraTrouble{CameraCause::kUnsupported, "buffers", 0};
  }
  const auto opened = open_v4l2_device(calls_, setup.device);
  if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&opened)) return *trouble;
  node_ = *std::get_if<V4l2Node>(&opened);

  // Before the signal is looked at, so that no change of it is missed.
  const bool tells_changes = subscribe(node_, V4L2_EVENT_SOURCE_CHANGE);
  const bool tells_end = subscribe(node_, V4L2_EVENT_EOS);
  tells_events_ = tells_changes || tells_end;

  const auto signal = settle_input(node_);
  if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&signal)) return *trouble;
  const auto settled = settle_format(node_, setup);
  if (const CameraTrouble* trouble = std::get_if<CameraTrouble>(&settled)) return *trouble;
  layout_ = *std::get_if<V4l2Layout>(&settled);
  const double signal_rate = std::get_if<V4l2Signal>(&signal)->rate;
  if (signal_rate > 0.0) layout_.mode.rate = signal_rate;

  if (const auto trouble = set_controls(node_, setup.controls)) return trouble;
  if (const auto trouble = buffers_.request(node_, layout_, setup.buffers)) return trouble;
  int type = static_cast<int>(node_.type());
  if (const int error = node_.ask(VIDIOC_STREAMON, &type)) return refused("VIDIOC_STREAMON", error);
  streaming_ = true;
  return std::nullopt;
}

void V4l2Camera::stop() noexcept {
  if (node_.descriptor < 0) return;
  int type = static_cast<int>(node_.type());
  const bool is_off = !streaming_ || node_.ask(VIDIOC_STREAMOFF, &type) == 0;
  buffers_.release(node_, is_off);
  calls_.close(node_.descriptor);
  node_.descriptor = -1;
  streaming_ = false;
  loss_.reset();
}

CameraPoll V4l2Camera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  if (!streaming_) return CameraPoll::kNothing;
  V4l2Buffers::Filled filled;
  if (!loss_) {
    const int error = buffers_.dequeue(node_, filled);
    if (error == EAGAIN) {
      loss_ = events();
      if (!loss_) return CameraPoll::kNothing;
    } else if (error != 0) {
      loss_ = refused("VIDIOC_DQBUF", error);
    }
  }
  if (loss_) {
    trouble = *loss_;
    return CameraPoll::kLost;
  }
  describe_frame(filled, frame);
  if ((filled.buffer.flags & V4L2_BUF_FLAG_ERROR) == 0 && is_whole(frame)) return CameraPoll::kFrame;
  if (const int error = buffers_.queue(node_, filled.buffer.index)) loss_ = refused("VIDIOC_QBUF", error);
  return CameraPoll::kDamaged;
}

// Drivers set no frame time while they stream.
bool V4l2Camera::set_control(const CameraControl& control) noexcept {
  if (!streaming_ || control.name == "frame_time") return false;
  try {
    return set_nearest_control(node_, control);
  } catch (const std::bad_alloc&) {
    return false;
  }
}

void V4l2Camera::give_back(const CameraFrame& frame) noexcept {
  if (!streaming_ || frame.buffer < 0 || !buffers_.is_lent(static_cast<std::size_t>(frame.buffer))) return;
  const int error = buffers_.queue(node_, static_cast<std::size_t>(frame.buffer));
  if (error != 0 && !loss_) loss_ = refused("VIDIOC_QBUF", error);
}

// A change of the signal or the end of the stream, if there was one.
std::optional<CameraTrouble> V4l2Camera::events() noexcept {
  if (!tells_events_) return std::nullopt;
  for (int i = 0; i < kMostEvents; ++i) {
    v4l2_event event{};
    const int error = node_.ask(VIDIOC_DQEVENT, &event);
    if (error == ENOENT || error == EAGAIN) return std::nullopt;  // no more of them
    if (error != 0) return refused("VIDIOC_DQEVENT", error);
    if (event.type == V4L2_EVENT_EOS) return CameraTrouble{CameraCause::kFailed, "end of stream", 0};
    if (event.type == V4L2_EVENT_SOURCE_CHANGE) {
      if (const auto trouble = missing_signal(node_)) return trouble;
      return CameraTrouble{CameraCause::kChanged, "source change", 0};
    }
  }
  return std::nullopt;
}

void V4l2Camera::describe_frame(const V4l2Buffers::Filled& filled, CameraFrame& frame) const noexcept {
  const std::size_t index = filled.buffer.index;
  frame.format = layout_.mode.format;
  frame.width = layout_.mode.width;
  frame.height = layout_.mode.height;
  frame.planes = {};
  for (int p = 0; p < plane_count(frame.format); ++p) {
    const V4l2PlanePlace& place = layout_.planes[static_cast<std::size_t>(p)];
    const V4l2Memory& memory = buffers_.memory(index, place.memory);
    const std::size_t used = filled.used[place.memory];
    const std::size_t offset = filled.begins[place.memory] + place.offset;
    CameraPlane& plane = frame.planes[static_cast<std::size_t>(p)];
    plane.data = memory.data + offset;
    plane.stride = place.stride;
    plane.bytes = std::min(used - std::min(place.offset, used), place.bytes);
    plane.dma_buf = memory.dma_buf;
    plane.offset = offset;
  }
  frame.sequence = filled.buffer.sequence;
  frame.captured_at = time_of(filled.buffer);
  frame.buffer = static_cast<int>(index);
}

// Modulo 2^64 nanoseconds: drivers can be told to be far in the future.
std::chrono::nanoseconds V4l2Camera::time_of(const v4l2_buffer& buffer) const noexcept {
  if ((buffer.flags & V4L2_BUF_FLAG_TIMESTAMP_MASK) != V4L2_BUF_FLAG_TIMESTAMP_MONOTONIC) return clock_.now();
  const auto nanoseconds = static_cast<std::uint64_t>(buffer.timestamp.tv_sec) * 1'000'000'000U +
                           static_cast<std::uint64_t>(buffer.timestamp.tv_usec) * 1000U;
  return std::chrono::nanoseconds(static_cast<std::int64_t>(nanoseconds));
}

}  // namespace cupola
