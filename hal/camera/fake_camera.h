// A camera of memory: pictures at a scripted rate on a fake clock, and faults at scripted times.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/camera/fake_picture.h"
#include "hal/time/clock.h"

namespace cupola {

enum class CameraFault : std::uint8_t {
  kDropped,        // `amount` per cent of the frames never come; their numbers are missing
  kDamaged,        // `amount` per cent of the frames come with the error flag
  kSilent,         // nothing comes, though the stream goes on
  kUnplugged,      // there is no such device
  kNoSignal,       // nothing is plugged into its input
  kStartFails,     // the driver refuses to start; a stream that runs goes on
  kWrongSize,      // it starts with half the height
  kWrongFormat,    // it starts with another format
  kWrongStride,    // frames come with rows that are too short
  kShort,          // frames come with half their bytes
  kTimestampStep,  // frames are stamped `amount` nanoseconds later
};

// From `from` on, before `until`.
struct FakeFault {
  CameraFault kind = CameraFault::kDropped;
  std::chrono::nanoseconds from{0};
  std::chrono::nanoseconds until = std::chrono::nanoseconds::max();
  std::int64_t amount = 100;
};

enum class FakeCrop : std::uint8_t {
  kNone,   // it sends everything
  kCuts,   // the area that is asked for, with even sides
  kZooms,  // it says that it sends that area, in as many texels as its whole picture
};

struct FakeCameraDevice {
  std::string name = "fake";  // setups that ask for another one find none; an empty one finds any
  int number = 0;             // in its pictures
  std::vector<CameraFormat> formats = {CameraFormat::kYuyv};
  int width = 64;  // the only size
  int height = 48;
  FakeCrop crop = FakeCrop::kNone;      // of kMjpeg always none
  double rate = 60.0;                   // frames a second, where the setup asks for none
  std::chrono::nanoseconds jitter{0};   // frames are captured up to so much later than their time
  std::chrono::nanoseconds latency{0};  // from capture until it can be polled
  double drift_ppm = 0.0;               // parts in a million that its clock is slow by
  std::uint32_t first_sequence = 0;     // of each run
  std::vector<FakeFault> faults;
};

class FakeCamera final : public Camera {
 public:
  // `clock` is borrowed for the camera's life.
  FakeCamera(FakeClock& clock, FakeCameraDevice device);

  std::variant<CameraMode, CameraTrouble> start(const CameraSetup& setup) noexcept override;
  void stop() noexcept override;
  CameraPoll poll(CameraFrame& frame, CameraTrouble& trouble) noexcept override;
  void give_back(const CameraFrame& frame) noexcept override;
  int descriptor() const noexcept override { return phase_ == Phase::kStopped ? -1 : alarm_; }
  // Takes exposure, gain and auto_exposure, which its pictures do not show, and frame_time from the next
  // frame on.
  bool set_control(const CameraControl& control) noexcept override;

  // From now on, until end_faults().
  void begin_fault(CameraFault kind, std::int64_t amount = 100);
  void end_faults();
  // Frames that it made so far, dropped ones too.
  std::uint64_t captured() const { return captured_; }

 private:
  enum class Phase : std::uint8_t { kStopped, kRunning, kLost };
  struct Ready {
    int buffer = 0;
    std::uint32_t sequence = 0;
    bool damaged = false;
    std::chrono::nanoseconds captured_at{0};
    std::chrono::nanoseconds due{0};
  };
  static constexpr std::size_t kMostBuffers = 32;

  const FakeFault* fault(CameraFault kind, std::chrono::nanoseconds when) const noexcept;
  bool hits(CameraFault kind, std::chrono::nanoseconds when) const noexcept;
  std::optional<CameraTrouble> refusal(std::chrono::nanoseconds now) const noexcept;
  std::chrono::nanoseconds due(std::uint64_t frame) const noexcept;
  void capture(std::chrono::nanoseconds now) noexcept;
  void lend(const Ready& ready, CameraFrame& frame) noexcept;
  void wind_alarm() noexcept;
  CameraPoll lose(const CameraTrouble& why, CameraTrouble& trouble) noexcept;

  FakeClock& clock_;
  FakeCameraDevice device_;
  int alarm_;
  Phase phase_ = Phase::kStopped;
  CameraTrouble loss_;
  CameraMode mode_;
  std::optional<FakePicture> picture_;             // whole
  std::vector<std::vector<std::uint8_t>> memory_;  // by buffer
  enum class Place : std::uint8_t { kDevice, kReady, kLent };
  std::array<Place, kMostBuffers> places_{};
  std::array<Ready, kMostBuffers> ready_{};  // a ring
  std::size_t first_ready_ = 0;
  std::size_t readies_ = 0;
  std::chrono::nanoseconds counts_from_{
      0};  // when frame first_ - 1 of this period was due, or would have been
  std::uint64_t first_ = 0;
  double period_ns_ = 0.0;
  std::uint64_t next_ = 0;      // frame of this run
  std::uint32_t sequence_ = 0;  // of the next frame
  std::uint64_t captured_ = 0;
};

}  // namespace cupola
