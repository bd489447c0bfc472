// The one place that knows every camera driver.
// SPDX-License-Identifier: MIT
#include "firmware/open_cameras.h"

#include <fmt/format.h>

#include <optional>

#include "hal/camera/fake_camera.h"
#include "pipeline/frame/error.h"
#ifdef CUPOLA_V4L2
#include "hal/camera/v4l2_camera.h"
#endif
#ifdef CUPOLA_LIBCAMERA
#include "hal/camera/libcamera_camera.h"
#endif

namespace cupola {
namespace {

constexpr int kFakeSide = 512;  // texels, where the rig names no size

// It has whatever the rig asks for.
FakeCameraDevice fake_device(const RigCamera& camera, std::size_t number) {
  const CameraSetup& setup = camera.setup;
  FakeCameraDevice device;
  device.name = setup.device;
  device.number = static_cast<int>(number);
  device.formats = setup.formats.empty() ? std::vector{CameraFormat::kNv12} : setup.formats;
  device.width = setup.width > 0 ? setup.width : kFakeSide;
  device.height = setup.height > 0 ? setup.height : kFakeSide;
  device.latency = std::chrono::milliseconds(4);
  return device;
}

[[noreturn]] [[maybe_unused]] void refuse(const RigCamera& camera, const char* driver) {
  throw Failure(fmt::format("camera of view {}: this program was built without {}", camera.view, driver));
}

}  // namespace

struct CameraDrivers::Shared {
#ifdef CUPOLA_V4L2
  LinuxCalls calls;
#endif
#ifdef CUPOLA_LIBCAMERA
  std::optional<LibcameraSystem> libcamera;
#endif
};

CameraDrivers::CameraDrivers() : shared_(std::make_unique<Shared>()) {}
CameraDrivers::~CameraDrivers() = default;

std::vector<OpenCamera> CameraDrivers::open(std::span<const RigCamera> cameras, Clock& clock,
                                            FakeClock* fake) {
  std::vector<OpenCamera> opened;
  for (const RigCamera& camera : cameras) {
    std::unique_ptr<Camera> device;
    switch (camera.driver) {
      case CameraDriver::kFake:
        if (!fake) {
          throw Failure(fmt::format(
              "camera of view {}: fake cameras go by the fake clock; expected --fast-forward", camera.view));
        }
        device = std::make_unique<FakeCamera>(*fake, fake_device(camera, opened.size()));
        break;
      case CameraDriver::kV4l2:
#ifdef CUPOLA_V4L2
        device = std::make_unique<V4l2Camera>(shared_->calls, clock);
        break;
#else
        refuse(camera, "V4L2");
#endif
      case CameraDriver::kLibcamera:
#ifdef CUPOLA_LIBCAMERA
        if (!shared_->libcamera) shared_->libcamera.emplace();
        device = std::make_unique<LibcameraCamera>(*shared_->libcamera, clock);
        break;
#else
        refuse(camera, "libcamera");
#endif
    }
    opened.push_back({camera, std::move(device)});
  }
  return opened;
}

}  // namespace cupola
