// The one place that knows every camera driver.
// SPDX-License-Identifier: MIT
#include "firmware/open_cameras.h"

#include <fmt/format.h>

#include <cstdio>
#include <optional>
#include <system_error>
#include <utility>

#include "hal/camera/fake_camera.h"
#include "hal/camera/mjpeg_camera.h"
#include "hal/camera/recorded_camera.h"
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

std::filesystem::path file_of(const std::filesystem::path& folder, const RigCamera& camera) {
  if (camera.view.find('/') != std::string::npos) {
    throw InputError(
        fmt::format("view {}: expected a name without / where cameras are recorded", camera.view));
  }
  return folder / (camera.view + ".camera");
}

void make_folder(const std::filesystem::path& folder) {
  std::error_code failed;
  std::filesystem::create_directories(folder, failed);
  if (failed) throw InputError(fmt::format("{}: {}", folder.string(), failed.message()));
}

std::unique_ptr<RecordedCamera> replay(const std::filesystem::path& file, Clock& clock, ReplayTime& time) {
  try {
    auto camera = std::make_unique<RecordedCamera>(clock, time, file);
    if (!camera->recording().is_whole()) {
      fmt::print(stderr, "cupola: {}: ends in the middle of a record at byte {}; played up to there\n",
                 file.string(), camera->recording().readable_bytes());
    }
    return camera;
  } catch (const std::runtime_error& error) {
    throw InputError(error.what());
  }
}

// As it was first started.
std::optional<CameraMode> first_mode(const RecordingReader& recording) {
  for (std::size_t i = 0; i < recording.size(); ++i) {
    const CameraRecord record = recording.at(i);
    if (record.kind == RecordKind::kStarted) return record.mode;
  }
  return std::nullopt;
}

std::unique_ptr<RecordingCamera> record(std::unique_ptr<Camera> device, const std::filesystem::path& file,
                                        Clock& clock, std::chrono::nanoseconds begin, bool at_once) {
  using Writing = CameraRecorder::Writing;
  try {
    auto recorder = std::make_unique<CameraRecorder>(file, at_once ? Writing::kAtOnce : Writing::kOnAThread);
    return std::make_unique<RecordingCamera>(std::move(device), clock, begin, std::move(recorder));
  } catch (const std::system_error& error) {
    throw InputError(error.what());
  }
}

[[noreturn]] [[maybe_unused]] void refuse(const RigCamera& camera, const char* driver) {
  throw Failure(fmt::format("camera of view {}: this program was built without {}", camera.view, driver));
}

}  // namespace

OpenCamera::OpenCamera(RigCamera camera, std::unique_ptr<Camera> camera_device, Clock& clock,
                       CameraWatch::Starting starting)
    : settings(std::move(camera)),
      device(std::move(camera_device)),
      watch(std::make_unique<CameraWatch>(*device, settings.setup, clock, settings.patience, starting)) {}

struct CameraDrivers::Shared {
  ReplayTime replay_time;
#ifdef CUPOLA_V4L2
  LinuxCalls calls;
#endif
#ifdef CUPOLA_LIBCAMERA
  std::optional<LibcameraSystem> libcamera;
#endif
};

CameraDrivers::CameraDrivers() : shared_(std::make_unique<Shared>()) {}
CameraDrivers::~CameraDrivers() = default;

std::unique_ptr<Camera> CameraDrivers::open_device(const RigCamera& camera, std::size_t number,
                                                   [[maybe_unused]] Clock& clock, FakeClock* fake) {
  switch (camera.driver) {
    case CameraDriver::kFake:
      if (!fake) {
        throw Failure(fmt::format(
            "camera of view {}: fake cameras go by the fake clock; expected --fast-forward", camera.view));
      }
      return std::make_unique<FakeCamera>(*fake, fake_device(camera, number));
    case CameraDriver::kV4l2:
#ifdef CUPOLA_V4L2
      return std::make_unique<V4l2Camera>(shared_->calls, clock);
#else
      refuse(camera, "V4L2");
#endif
    case CameraDriver::kLibcamera:
#ifdef CUPOLA_LIBCAMERA
      if (!shared_->libcamera) shared_->libcamera.emplace();
      return std::make_unique<LibcameraCamera>(*shared_->libcamera, clock);
#else
      refuse(camera, "libcamera");
#endif
  }
  return nullptr;
}

std::vector<OpenCamera> CameraDrivers::open(std::span<const RigCamera> cameras, Clock& clock, FakeClock* fake,
                                            const CameraRecordings& recordings) {
  if (!recordings.record.empty()) make_folder(recordings.record);
  const std::chrono::nanoseconds begin = clock.now();
  // Recordings share the time that they are played in.
  const auto starting =
      fake || !recordings.replay.empty() ? CameraWatch::Starting::kInPoll : CameraWatch::Starting::kOnAThread;
  std::vector<OpenCamera> opened;
  for (const RigCamera& camera : cameras) {
    std::unique_ptr<Camera> device;
    std::optional<CameraMode> whole;
    if (recordings.replay.empty()) {
      device = open_device(camera, opened.size(), clock, fake);
    } else {
      auto recorded = replay(file_of(recordings.replay, camera), clock, shared_->replay_time);
      if (recordings.from_first_frame) {
        recorded->pass_over_empty_starts();
        whole = first_mode(recorded->recording());
      }
      device = std::move(recorded);
    }
    const RecordingCamera* recording = nullptr;
    if (!recordings.record.empty()) {
      auto made =
          record(std::move(device), file_of(recordings.record, camera), clock, begin, fake != nullptr);
      recording = made.get();
      device = std::move(made);
    }
    const auto decoding = fake ? MjpegCamera::Decoding::kInPoll : MjpegCamera::Decoding::kOnAThread;
    opened.emplace_back(camera, std::make_unique<MjpegCamera>(std::move(device), clock, decoding), clock,
                        starting);
    opened.back().recording = recording;
    opened.back().whole = whole;
  }
  return opened;
}

}  // namespace cupola
