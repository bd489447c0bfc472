// What takes a device its time, starts and controls, on a thread of its own.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <optional>
#include <thread>
#include <variant>

#include "hal/camera/camera.h"
#include "hal/camera/hand_over.h"

namespace cupola {

using CameraStart = std::variant<CameraMode, CameraTrouble>;

// One start and one set of controls at a time. From begin_start() until take_start() has what came of it the
// camera is the thread's alone. Nothing allocates after construction but the camera itself.
class CameraChores {
 public:
  static constexpr std::size_t kMostControls = 3;
  using Controls = std::array<CameraControl, kMostControls>;  // those without a name are none

  // `camera` is borrowed for the chores' life. Throws std::system_error where there is no thread or no
  // descriptor to be had.
  explicit CameraChores(Camera& camera);
  ~CameraChores();
  CameraChores(const CameraChores&) = delete;
  CameraChores& operator=(const CameraChores&) = delete;

  // `setup` is borrowed until take_start() or finish(). Controls that are under way are set first.
  void begin_start(const CameraSetup& setup) noexcept;
  bool starting() const noexcept { return starting_; }
  // What came of it, once it has; does not wait.
  std::optional<CameraStart> take_start() noexcept;

  // Copied. Names of up to 15 letters, which strings hold without the heap.
  void begin_controls(const Controls& controls) noexcept;
  bool setting() noexcept;  // they are under way

  // Waits for what is under way, and drops what comes of it.
  void finish() noexcept;
  // Can be read when take_start() has something; now and then for nothing.
  int descriptor() const noexcept { return done_.descriptor(); }

 private:
  void work() noexcept;
  bool done(int chore) noexcept;

  Camera& camera_;
  const CameraSetup* setup_ = nullptr;
  CameraStart came_;
  Controls controls_;
  bool starting_ = false;
  bool setting_ = false;
  HandOver asked_;
  HandOver done_;
  std::thread thread_;
};

}  // namespace cupola
