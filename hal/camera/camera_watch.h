// Keeps one camera's stream going: barks at silence, counts what went wrong by cause, and starts again what
// was lost.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <optional>

#include "hal/camera/camera.h"
#include "hal/camera/camera_chores.h"
#include "hal/time/clock.h"

namespace cupola {

enum class CameraState : std::uint8_t { kStreaming, kLost };

struct CameraCounts {
  std::uint64_t frames = 0;    // handed on
  std::uint64_t dropped = 0;   // by the device: gaps in the sequence within one run
  std::uint64_t damaged = 0;   // error flag or too short
  std::uint64_t silences = 0;  // times that the watchdog barked
  std::uint64_t losses = 0;    // times that frames ceased to flow, silences included
  std::uint64_t starts = 0;    // streams that began
  std::uint64_t failed_starts = 0;
  std::uint64_t clock_steps = 0;  // of the device: times that its clock ran backwards or ahead of ours
  // Losses and failed starts by their cause, by one as long as the same cause lasts.
  std::array<std::uint64_t, kCameraCauses> causes{};
  std::uint64_t of(CameraCause cause) const { return causes[static_cast<std::size_t>(cause)]; }
};

class CameraWatch {
 public:
  enum class Starting : std::uint8_t {
    kInPoll,     // by poll(), which takes as long as the device does: the same steps every time
    kOnAThread,  // of the watch's own; poll() says kNothing meanwhile. Controls are set there too
  };
  // `camera` and `clock` are borrowed for the watch's life. `patience`: the longest silence that is taken for
  // life. A lost camera is tried again at once, then every frame period (40 ms where the rate is not known);
  // one that was started and sent nothing yet, every two seconds. A setup that names a size is kept to: a
  // camera that comes back with another format, size or crop than it had is not taken (kChanged). With
  // kOnAThread throws std::system_error where there is no thread to be had.
  CameraWatch(Camera& camera, CameraSetup setup, Clock& clock, std::chrono::nanoseconds patience,
              Starting starting = Starting::kInPoll);
  ~CameraWatch();
  CameraWatch(const CameraWatch&) = delete;
  CameraWatch& operator=(const CameraWatch&) = delete;

  enum class Poll : std::uint8_t {
    kFrame,
    kNothing,
    kLost,  // said once a loss, or when the first start fails; from then on kNothing until frames flow
            // again. Lent frames can be read until the next poll()
    kBack,  // said once a return, and when the camera first comes, before the first frame, which the next
            // poll() has; mode() may be another one
  };
  // Starts the camera when it is not running and its time has come. Does not wait; allocates only in a start.
  // Sequences never run backwards: a new run goes on where the last one ended. Timestamps always rise.
  Poll poll(CameraFrame& frame) noexcept;
  // Frames of a run that is over are passed over.
  void give_back(const CameraFrame& frame) noexcept;
  // Ends the stream; the next poll begins it again. With another setup: reconfigures. Both wait for a start
  // that is under way.
  void stop() noexcept;
  void set_setup(CameraSetup setup);

  // From the next poll on, and again in every stream that begins; a value that the device does not take is
  // lost. Does not allocate.
  enum class Dial : std::uint8_t { kExposure, kGain, kFrameTime };  // Camera::set_control()'s
  void turn(Dial dial, double value) noexcept;

  // Can be read when poll() has something to say; -1: not before deadline().
  int descriptor() const noexcept;
  bool running() const noexcept { return running_; }  // started, though perhaps no frame came yet
  // When poll() should be called at the latest: the watchdog's or the next start's time.
  std::chrono::nanoseconds deadline() const noexcept;
  CameraState state() const noexcept { return state_; }
  const CameraMode& mode() const noexcept { return mode_; }           // of the last start that succeeded
  const CameraTrouble& trouble() const noexcept { return trouble_; }  // of the last loss or failed start
  const CameraCounts& counts() const noexcept { return counts_; }

 private:
  enum class Start : std::uint8_t { kDone, kUnderWay, kFailed };
  Start start(CameraTrouble& trouble) noexcept;
  std::optional<CameraStart> begun() noexcept;
  void set_dials() noexcept;
  Poll lose(const CameraTrouble& trouble) noexcept;
  Poll listen() noexcept;
  Poll report(const CameraTrouble& trouble) noexcept;
  bool is_as_agreed(const CameraMode& mode) const noexcept;
  std::uint64_t unwrap(std::uint64_t sequence) noexcept;
  std::chrono::nanoseconds sane_time(std::chrono::nanoseconds captured_at, std::uint64_t gap) noexcept;
  std::chrono::nanoseconds period() const noexcept;
  std::chrono::nanoseconds silence_ends() const noexcept;

  Camera& camera_;
  std::optional<CameraChores> chores_;  // none: kInPoll
  CameraSetup setup_;
  CameraChores::Controls dials_;  // those that were turned
  bool turned_ = false;           // and the stream has not got them yet
  Clock& clock_;
  std::chrono::nanoseconds patience_;
  CameraState state_ = CameraState::kLost;
  bool running_ = false;
  bool reported_ = false;  // this loss was told
  bool agreed_ = false;    // mode_ is of this setup
  CameraMode mode_;
  CameraTrouble trouble_;
  CameraCounts counts_;
  std::chrono::nanoseconds alive_at_{0};                                   // the last frame or start
  std::chrono::nanoseconds next_start_ = std::chrono::nanoseconds::min();  // while it does not run
  std::optional<CameraFrame> first_;                                       // waits behind kBack
  std::optional<std::uint32_t> count_;                                     // the device's, in this run
  std::uint64_t sequence_ = 0;                                             // of the last frame, unwrapped
  bool any_ = false;                                                       // sequence_ and stamp_ are set
  std::uint64_t run_begins_ = 0;                                           // first sequence of this run
  std::chrono::nanoseconds stamp_ = std::chrono::nanoseconds::min();       // of the last frame, sane
  std::uint64_t clock_offset_ = 0;  // nanoseconds from the device's clock to ours, modulo 2^64, after a step
};

}  // namespace cupola
