// V4L2 devices in user space: what the kernel's drivers do when they are asked, on a fake clock, with faults
// and with a record of everything that a program did wrong.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include <linux/videodev2.h>

#include "hal/camera/fake_camera.h"
#include "hal/camera/system_calls.h"
#include "hal/time/clock.h"

namespace cupola {

struct FakeV4l2Control {
  __u32 id = 0;
  std::string name;
  __u32 type = V4L2_CTRL_TYPE_INTEGER;
  std::int64_t minimum = 0;
  std::int64_t maximum = 100;
  std::int64_t value = 0;
  std::vector<std::int64_t> refused;  // values that it has not, though they lie in between
};

struct FakeV4l2Device {
  int node = 0;  // of /dev/video
  std::string card = "Fake camera";
  std::string bus = "platform:fake-000";
  bool multi_planar = false;
  bool captures = true;  // else it is a node of another kind
  std::vector<__u32> fourccs = {V4L2_PIX_FMT_YUYV};
  int width = 64;  // of the sensor, or of the signal
  int height = 48;
  double rate = 60.0;
  bool hdmi = false;  // its input has timings; else it is a sensor
  bool can_crop = true;
  bool can_export = true;
  bool sets_rate = true;
  bool stamps = true;  // with CLOCK_MONOTONIC
  __u32 padding = 0;   // bytes at the end of each row of the first plane (half of it for I420's others)
  __u32 header = 0;    // bytes before the picture (multi-planar only)
  __u32 field = V4L2_FIELD_NONE;
  __u32 colorspace = V4L2_COLORSPACE_REC709;
  __u32 least_buffers = 2;
  __u32 most_buffers = VIDEO_MAX_FRAME;
  __u32 missing_image_bytes = 0;  // of what it says a picture takes (single-planar only)
  __u32 missing_bytes = 0;        // of each buffer, against what it said
  bool numbers_buffers = true;    // else it says that it filled one that it was not given
  __u32 first_sequence = 0;       // of each stream
  int number = 0;                 // in its pictures
  std::vector<FakeV4l2Control> controls;
};

class FakeV4l2Node;

// What the caller has open or mapped, and what it did wrong.
struct FakeV4l2Ledger {
  struct Mapping {
    std::unique_ptr<std::uint8_t[]> memory;  // ends with the mapping, so that a sanitizer sees later use
    std::size_t length = 0;
  };
  std::vector<std::string> misuse;
  std::map<void*, Mapping> mappings;
  std::vector<int> dma_bufs;
  int next_dma_buf = 1 << 20;
};

struct FakeV4l2File {
  int descriptor = -1;
  FakeV4l2Node* node = nullptr;
  bool gone = false;  // its device was unplugged since
  std::vector<__u32> subscriptions;
  std::deque<v4l2_event> events;
};

class FakeV4l2 final : public SystemCalls {
 public:
  // Calls other than ioctls, where one is named by its request.
  static constexpr unsigned long kOpen = 1;
  static constexpr unsigned long kClose = 2;
  static constexpr unsigned long kMmap = 3;
  static constexpr unsigned long kMunmap = 4;

  // `clock` is borrowed for its life.
  explicit FakeV4l2(FakeClock& clock);
  ~FakeV4l2() override;

  FakeV4l2Node& add(FakeV4l2Device device);
  // From now on the `nth` such call (1 is the next) fails, and all later ones where `for_good`. close and
  // munmap do their work all the same, as the kernel's do.
  void fail(unsigned long call, std::uint64_t nth, int error, bool for_good);
  void heal() { failing_ = 0; }
  // Whether fail()'s call came.
  bool has_failed() const { return has_failed_; }
  // Misuse and leaks, a line each; empty is as it should be once every camera has stopped.
  std::string complaints() const;
  std::uint64_t calls() const { return calls_; }

  int open(const char* path, int flags) noexcept override;
  int close(int descriptor) noexcept override;
  int ioctl(int descriptor, unsigned long request, void* argument) noexcept override;
  void* mmap(std::size_t length, int descriptor, long offset) noexcept override;
  int munmap(void* address, std::size_t length) noexcept override;

 private:
  FakeV4l2File* file(int descriptor);
  bool fails(unsigned long call) noexcept;

  FakeClock& clock_;
  FakeV4l2Ledger ledger_;
  std::vector<std::unique_ptr<FakeV4l2Node>> nodes_;
  std::vector<std::unique_ptr<FakeV4l2File>> files_;
  std::deque<int> free_alarms_;  // descriptors are alarms: those who wait for them are woken
  unsigned long failing_ = 0;
  std::uint64_t until_failure_ = 0;
  int failure_ = 0;
  bool for_good_ = false;
  bool has_failed_ = false;
  std::uint64_t calls_ = 0;
};

}  // namespace cupola
