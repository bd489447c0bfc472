// One device of a FakeV4l2: its settings, its buffers and the frames it makes.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <deque>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera/camera_planes.h"
#include "hal/camera/fake_picture.h"
#include "tests/hal/fake_v4l2.h"

namespace cupola {

class FakeV4l2Node {
 public:
  FakeV4l2Node(FakeClock& clock, FakeV4l2Ledger& ledger, FakeV4l2Device device);

  // Faults begin now and end together.
  void begin_fault(CameraFault fault, std::int64_t amount);
  void end_faults();
  // Tells those who subscribed to it.
  void send_event(__u32 type);
  // Another signal than before, as if its source were switched over.
  void change_signal(int width, int height, double rate);
  // The next buffer is filled as the last of its stream: what comes after is EPIPE.
  void end_stream() { ended_ = true; }
  std::int64_t control(const std::string& name) const;
  FakeV4l2Device& device() { return device_; }

  // For FakeV4l2.
  std::string path() const { return "/dev/video" + std::to_string(device_.node); }
  bool is_unplugged() const { return has(CameraFault::kUnplugged) != nullptr; }
  void join(FakeV4l2File& file);
  void leave(FakeV4l2File& file);
  int ioctl(FakeV4l2File& file, unsigned long request, void* argument);
  void* map(std::size_t length, long offset);

 private:
  struct Piece {
    std::size_t bytes = 0;
    void* mapped = nullptr;
  };
  struct Buffer {
    enum class Place { kCaller, kQueued, kDone } place = Place::kCaller;
    std::vector<Piece> pieces;
    __u32 flags = 0;
    __u32 sequence = 0;
    std::uint64_t stamp_ns = 0;
    std::vector<std::size_t> used;
  };
  struct Settings {
    __u32 fourcc = 0;
    __u32 width = 0;
    __u32 height = 0;
  };
  struct Fault {
    CameraFault kind;
    std::int64_t amount;
  };
  // Of a picture in memory as the settings have it.
  struct Sizes {
    CameraFormat format = CameraFormat::kYuyv;
    std::vector<__u32> strides;  // by piece of memory
    std::vector<__u32> bytes;
  };

  const Fault* has(CameraFault kind) const;
  bool hits(CameraFault kind) const;
  int misuse(const char* what, int error);
  Sizes sizes() const;
  v4l2_buf_type type() const;
  void catch_up();
  void fill(Buffer& buffer, std::chrono::nanoseconds when);
  void paint(Buffer& buffer);
  void wind_alarms();
  std::chrono::nanoseconds due(std::uint64_t frame) const;
  void stop();

  int settings_ioctl(FakeV4l2File& file, unsigned long request, void* argument);  // fake_v4l2_settings.cpp
  int input_ioctl(unsigned long request, void* argument);
  int control_ioctl(unsigned long request, void* argument);
  int set_format(v4l2_format& format, bool is_set);
  int select(v4l2_selection& selection, bool is_set);
  int stream_ioctl(FakeV4l2File& file, unsigned long request, void* argument);
  int request_buffers(FakeV4l2File& file, v4l2_requestbuffers& wanted);
  int describe_buffer(v4l2_buffer& buffer);
  int queue_buffer(const v4l2_buffer& buffer);
  int dequeue_buffer(v4l2_buffer& buffer);
  int subscribe(FakeV4l2File& file, const v4l2_event_subscription& subscription);
  int dequeue_event(FakeV4l2File& file, v4l2_event& event);

  FakeClock& clock_;
  FakeV4l2Ledger& ledger_;
  FakeV4l2Device device_;
  Settings settings_;
  v4l2_rect crop_{};
  double rate_ = 0.0;
  std::vector<FakeV4l2File*> files_;
  const FakeV4l2File* owner_ = nullptr;  // of the buffers
  std::vector<Buffer> buffers_;
  std::deque<std::size_t> queued_;
  std::deque<std::size_t> done_;
  std::vector<Fault> faults_;
  std::optional<FakePicture> picture_;
  std::vector<std::uint8_t> drawn_;
  bool streaming_ = false;
  bool ended_ = false;
  bool past_end_ = false;
  std::chrono::nanoseconds started_at_{0};
  std::uint64_t next_ = 0;
  std::uint64_t made_ = 0;
  __u32 sequence_ = 0;
};

}  // namespace cupola
