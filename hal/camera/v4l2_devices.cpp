// Device nodes are asked one after the other: there are at most 256.
// SPDX-License-Identifier: MIT
#include "hal/camera/v4l2_devices.h"

#include <cerrno>
#include <cstring>

#include <fcntl.h>

namespace cupola {

namespace {

constexpr int kMostNodes = 256;

std::string path_of(int number) {
  return "/dev/video" + std::to_string(number);
}

template <std::size_t n>
std::string text(const __u8 (&field)[n]) {
  const char* begin = reinterpret_cast<const char*>(field);
  return {begin, strnlen(begin, n)};
}

struct Opened {
  V4l2Device device;
  V4l2Node node;  // descriptor -1 where it could not be opened
};

// What it is; `unusable` where it is no camera. The caller closes it.
Opened open_node(SystemCalls& calls, const std::string& path) {
  Opened opened;
  opened.device.path = path;
  opened.node.calls = &calls;
  do {
    opened.node.descriptor = calls.open(path.c_str(), O_RDWR | O_NONBLOCK | O_CLOEXEC);
  } while (opened.node.descriptor < 0 && errno == EINTR);
  if (opened.node.descriptor < 0) {
    opened.device.unusable = refused("open", errno);
    return opened;
  }
  v4l2_capability capability{};
  if (const int error = opened.node.ask(VIDIOC_QUERYCAP, &capability)) {
    opened.device.unusable = refused("VIDIOC_QUERYCAP", error);
    if (error == ENOTTY || error == EINVAL) opened.device.unusable->cause = CameraCause::kUnsupported;
    return opened;
  }
  opened.device.driver = text(capability.driver);
  opened.device.card = text(capability.card);
  opened.device.bus = text(capability.bus_info);
  const bool of_node = (capability.capabilities & V4L2_CAP_DEVICE_CAPS) != 0;
  const __u32 able = of_node ? capability.device_caps : capability.capabilities;
  opened.node.multi_planar = (able & V4L2_CAP_VIDEO_CAPTURE_MPLANE) != 0;
  if ((able & (V4L2_CAP_VIDEO_CAPTURE | V4L2_CAP_VIDEO_CAPTURE_MPLANE)) == 0) {
    opened.device.unusable = CameraTrouble{CameraCause::kUnsupported, "captures no video", 0};
  } else if ((able & V4L2_CAP_STREAMING) == 0) {
    opened.device.unusable = CameraTrouble{CameraCause::kUnsupported, "does not stream", 0};
  }
  return opened;
}

void close_node(const V4l2Node& node) {
  if (node.descriptor >= 0) node.calls->close(node.descriptor);
}

}  // namespace

std::vector<V4l2Device> list_v4l2_devices(SystemCalls& calls) {
  std::vector<V4l2Device> devices;
  for (int number = 0; number < kMostNodes; ++number) {
    Opened opened = open_node(calls, path_of(number));
    close_node(opened.node);
    const bool exists = !opened.device.unusable || opened.device.unusable->cause != CameraCause::kMissing;
    if (exists) devices.push_back(std::move(opened.device));
  }
  return devices;
}

std::variant<V4l2Node, CameraTrouble> open_v4l2_device(SystemCalls& calls, const std::string& name) {
  if (name.starts_with('/')) {
    const Opened opened = open_node(calls, name);
    if (!opened.device.unusable) return opened.node;
    close_node(opened.node);
    return *opened.device.unusable;
  }
  for (int number = 0; number < kMostNodes; ++number) {
    const Opened opened = open_node(calls, path_of(number));
    const V4l2Device& device = opened.device;
    const bool meant = name.empty() || name == device.bus || name == device.card;
    if (meant && !device.unusable) return opened.node;
    close_node(opened.node);
  }
  return CameraTrouble{CameraCause::kMissing, "name", ENODEV};
}

}  // namespace cupola
