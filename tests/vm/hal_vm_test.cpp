// Runs inside a virtual machine (tests/vm/guest): the kernel's drivers answer at their device nodes.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <gtest/gtest.h>
#include <linux/videodev2.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <cstdio>
#include <filesystem>
#include <string>
#include <string_view>

namespace {

class DeviceNode {
 public:
  explicit DeviceNode(const std::filesystem::path& path)
      : descriptor_(open(path.c_str(), O_RDWR | O_CLOEXEC)) {}
  ~DeviceNode() {
    if (descriptor_ >= 0) close(descriptor_);
  }
  DeviceNode(const DeviceNode&) = delete;
  DeviceNode& operator=(const DeviceNode&) = delete;

  template <typename Argument>
  bool answers(unsigned long request, Argument& argument) const {
    return descriptor_ >= 0 && ioctl(descriptor_, request, &argument) == 0;
  }

 private:
  int descriptor_;
};

// How many nodes /dev/[folder/]prefix* are the driver's, as `named(node)` tells.
template <typename Named>
int nodes_of(const std::filesystem::path& folder, std::string_view prefix, std::string_view driver,
             Named named) {
  int found = 0;
  for (const auto& entry : std::filesystem::directory_iterator(folder)) {
    if (entry.path().filename().string().starts_with(prefix) && named(DeviceNode(entry.path())) == driver) {
      ++found;
    }
  }
  return found;
}

std::string video_driver(const DeviceNode& node) {
  v4l2_capability capability{};
  if (!node.answers(VIDIOC_QUERYCAP, capability)) return {};
  return reinterpret_cast<const char*>(capability.driver);
}

TEST(Vivid, IsFourCameras) {
  const int found = nodes_of("/dev", "video", "vivid", video_driver);
  EXPECT_EQ(found, 4);
  std::printf("vivid: %d nodes\n", found);
}

}  // namespace
