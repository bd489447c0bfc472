// Devices for a rig's cameras.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <vector>

#include "firmware/rig_cameras.h"
#include "hal/camera/camera_watch.h"
#include "hal/camera/recording_camera.h"
#include "hal/time/clock.h"

namespace cupola {

// A rig's camera, its device, and the watch that keeps it going.
struct OpenCamera {
  // Nothing is started yet. `clock` is borrowed for the camera's life.
  OpenCamera(RigCamera camera, std::unique_ptr<Camera> camera_device, Clock& clock,
             CameraWatch::Starting starting = CameraWatch::Starting::kInPoll);

  RigCamera settings;
  std::unique_ptr<Camera> device;
  const RecordingCamera* recording = nullptr;  // within the device, where it is recorded
  std::optional<CameraMode>
      whole;  // of a recording from its first frame on: what it was before it was cropped
  std::unique_ptr<CameraWatch> watch;
};

// Folders with a file VIEW.camera a camera; empty: none.
struct CameraRecordings {
  std::filesystem::path record;   // what the cameras say goes there
  std::filesystem::path replay;   // what they said then stands in for the rig's own
  bool from_first_frame = false;  // replayed without the starts that nothing came of
};

// Drivers that several cameras share. Outlives the cameras.
class CameraDrivers {
 public:
  CameraDrivers();
  ~CameraDrivers();
  CameraDrivers(const CameraDrivers&) = delete;
  CameraDrivers& operator=(const CameraDrivers&) = delete;

  // One a rig camera, not started; throws Failure for a driver that this program was built without, and
  // InputError for recordings that cannot be read or made. Fake cameras need the fake clock: without it
  // (null) they are refused. Real ones are started on threads of their own. The clocks are borrowed for the
  // cameras' life.
  std::vector<OpenCamera> open(std::span<const RigCamera> cameras, Clock& clock, FakeClock* fake,
                               const CameraRecordings& recordings = {});

 private:
  struct Shared;
  std::unique_ptr<Camera> open_device(const RigCamera& camera, std::size_t number, Clock& clock,
                                      FakeClock* fake);
  std::unique_ptr<Shared> shared_;
};

}  // namespace cupola
