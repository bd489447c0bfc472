// libcamera's cameras and the one CameraManager that they share.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "hal/camera/camera.h"

namespace libcamera {
class Camera;
}

namespace cupola {

struct LibcameraListing {
  std::string id;       // stays the same as long as the camera is plugged in where it is
  std::string model;    // the sensor's; several cameras may have the same
  std::string trouble;  // why it cannot be used now; empty: it can
};

// Which camera is meant: by id, by model where only one has it, or "#0", "#1", ... in libcamera's order.
std::variant<std::size_t, CameraTrouble> find_camera(std::span<const LibcameraListing> cameras,
                                                     std::string_view name);

// Starts libcamera's thread, which notices cameras that come and go. libcamera allows one of these a process
// at a time. Any thread. libcamera itself is silent, as each trouble is a value; LIBCAMERA_LOG_LEVELS changes
// that.
class LibcameraSystem {
 public:
  LibcameraSystem();
  ~LibcameraSystem();  // after all its LibcameraCameras
  LibcameraSystem(const LibcameraSystem&) = delete;
  LibcameraSystem& operator=(const LibcameraSystem&) = delete;

  // Why there can be no cameras at all, if so.
  std::optional<CameraTrouble> trouble();
  // Opens each camera for a moment.
  std::vector<LibcameraListing> list();
  // "v0.0.3"
  static std::string version();

  // For LibcameraCamera: the camera of that name, which is its alone until it is put back.
  std::variant<std::shared_ptr<libcamera::Camera>, CameraTrouble> take(std::string_view name);
  // `gone`: its device does not answer any more. libcamera notices that of USB cameras alone; of others it
  // does when it begins anew, which is done here unless another camera is taken.
  void put_back(std::shared_ptr<libcamera::Camera> camera, bool gone);
  // Returns when libcamera's thread has done what was asked of it so far, calls of slots included.
  void settle();

 private:
  struct Parts;

  void begin();
  void end();

  std::optional<CameraTrouble> trouble_;
  std::unique_ptr<Parts> parts_;
};

}  // namespace cupola
