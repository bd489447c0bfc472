// Devices for a rig's cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "firmware/live_frames.h"
#include "firmware/rig_cameras.h"
#include "hal/time/clock.h"

namespace cupola {

// Drivers that several cameras share. Outlives the cameras.
class CameraDrivers {
 public:
  CameraDrivers();
  ~CameraDrivers();
  CameraDrivers(const CameraDrivers&) = delete;
  CameraDrivers& operator=(const CameraDrivers&) = delete;

  // One a rig camera, not started; throws Failure for a driver that this program was built without. Fake
  // cameras need the fake clock: without it (null) they are refused. The clocks are borrowed for the cameras'
  // life.
  std::vector<OpenCamera> open(std::span<const RigCamera> cameras, Clock& clock, FakeClock* fake);

 private:
  struct Shared;
  std::unique_ptr<Shared> shared_;
};

}  // namespace cupola
