// A camera under test, with its time and with what can be done to it; and how to make one.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <ostream>
#include <vector>

#include "hal/camera/camera.h"
#include "hal/camera/fake_camera.h"
#include "hal/time/clock.h"

namespace cupola {

class CameraStage {
 public:
  virtual ~CameraStage() = default;
  virtual Clock& clock() = 0;
  virtual Camera& camera() = 0;
  // One that works, with a size and a rate.
  virtual CameraSetup setup() = 0;
  // One of the stage's own faults, from now on until end_faults(): then the device is as it was.
  virtual void begin_fault(CameraFault fault, std::int64_t amount) = 0;
  virtual void end_faults() = 0;
};

struct CameraStageMaker {
  const char* name;
  std::unique_ptr<CameraStage> (*make)();
  // By how much what happens may be later than in theory: 0 on a fake clock.
  std::chrono::nanoseconds lateness{0};
  bool stamped = true;  // its pictures are FakePicture's
  std::vector<CameraFault> faults;
  std::chrono::seconds faults_last{10};
  bool counts_drops = true;  // its sequence goes on while it has no buffer to fill
  int buffers = 0;           // that it insists on; 0: it has as many as it is asked for
};

inline void PrintTo(const CameraStageMaker& maker, std::ostream* out) {
  *out << maker.name;
}

}  // namespace cupola
