// Keeps one camera's stream going: barks at silence, counts what went wrong by cause, and starts again what
// was lost. SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>

#include "hal/camera/camera.h"
#include "hal/time/clock.h"

namespace cupola {

enum class CameraState : std::uint8_t { kStreaming, kLost };

struct CameraCounts {
  std::uint64_t frames = 0;    // handed on
  std::uint64_t dropped = 0;   // by the device: gaps in the sequence within one run
  std::uint64_t damaged = 0;   // error flag or too short
  std::uint64_t silences = 0;  // times that the watchdog barked
  std::uint64_t losses = 0;    // streams that ended, silences included
  std::uint64_t starts = 0;    // streams that began
  std::uint64_t failed_starts = 0;
  std::uint64_t clock_steps = 0;  // timestamps that were not later than the one before, or in the future
};

class CameraWatch {
 public:
  // `camera` and `clock` are borrowed for the watch's life. `patience`: the longest silence that is taken for
  // life. A lost camera is tried again every frame period (40 ms where the rate is not known).
  CameraWatch(Camera& camera, CameraSetup setup, Clock& clock, std::chrono::nanoseconds patience);
  ~CameraWatch();
  CameraWatch(const CameraWatch&) = delete;
  CameraWatch& operator=(const CameraWatch&) = delete;

  enum class Poll : std::uint8_t {
    kFrame,
    kNothing,
    kLost,  // said once a loss; from then on kNothing until frames flow again
    kBack,  // said once a return, before its first frame; mode() may be another one
  };
  // Starts the camera when it is not running and its time has come. Does not wait; allocates only in a start.
  Poll poll(CameraFrame& frame) noexcept;
  void give_back(const CameraFrame& frame) noexcept { camera_.give_back(frame); }
  // Ends the stream; the next poll begins it again. With another setup: reconfigures.
  void stop() noexcept;
  void set_setup(CameraSetup setup);

  int descriptor() const noexcept { return camera_.descriptor(); }
  // When poll() should be called at the latest: the watchdog's or the next start's time.
  std::chrono::nanoseconds deadline() const noexcept;
  CameraState state() const noexcept { return state_; }
  const CameraMode& mode() const noexcept { return mode_; }           // of the last start that succeeded
  const CameraTrouble& trouble() const noexcept { return trouble_; }  // of the last loss or failed start
  const CameraCounts& counts() const noexcept { return counts_; }

 private:
  void lose(const CameraTrouble& trouble) noexcept;
  bool start() noexcept;

  Camera& camera_;
  CameraSetup setup_;
  Clock& clock_;
  std::chrono::nanoseconds patience_;
  CameraState state_ = CameraState::kLost;
  CameraMode mode_;
  CameraTrouble trouble_;
  CameraCounts counts_;
  std::chrono::nanoseconds alive_at_{0};    // the last sign of life: a frame or a start
  std::chrono::nanoseconds next_start_{0};  // while lost
  std::optional<std::uint64_t> sequence_;   // of the last frame of this run, unwrapped
};

}  // namespace cupola
