// CameraManager: names, owners and hot-plug.
// SPDX-License-Identifier: MIT
#include "hal/camera/libcamera_system.h"

#include <algorithm>
#include <atomic>
#include <charconv>
#include <cstdlib>
#include <mutex>
#include <utility>

#include "hal/camera/libcamera_format.h"
#include "hal/camera/libcamera_version.h"

namespace cupola {

std::variant<std::size_t, CameraTrouble> find_camera(std::span<const LibcameraListing> cameras,
                                                     std::string_view name) {
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (cameras[i].id == name) return i;
  }
  std::optional<std::size_t> of_model;
  for (std::size_t i = 0; i < cameras.size(); ++i) {
    if (name.empty() || cameras[i].model != name) continue;
    if (of_model) return CameraTrouble{CameraCause::kUnsupported, "several cameras of this model", 0};
    of_model = i;
  }
  if (of_model) return *of_model;
  if (name.starts_with('#')) {
    std::size_t index = 0;
    const char* end = name.data() + name.size();
    const auto [rest, error] = std::from_chars(name.data() + 1, end, index);
    if (error == std::errc() && rest == end && index < cameras.size()) return index;
  }
  return CameraTrouble{CameraCause::kMissing, "CameraManager::cameras", 0};
}

namespace {

// Lives on libcamera's thread, so that one can wait for that thread.
class Milestone final : public libcamera::Object {
 public:
  void pass() {}
};

}  // namespace

struct LibcameraSystem::Parts {
  std::unique_ptr<libcamera::CameraManager> manager;
  std::atomic<Milestone*> milestone{nullptr};
  std::mutex mutex;
  std::vector<libcamera::Camera*> taken;  // by this program

  // On libcamera's thread: an object belongs to the thread that makes it.
  void see_camera(std::shared_ptr<libcamera::Camera>) {
    if (!milestone.load()) milestone = new Milestone;
  }
  bool is_taken(const libcamera::Camera* camera) const {
    return std::find(taken.begin(), taken.end(), camera) != taken.end();
  }
};

namespace {

std::string trouble_with(libcamera::Camera& camera) {
  if (camera.acquire() != 0) return "another program has it";
  const auto configuration = generate_configuration(camera, libcamera::StreamRole::VideoRecording);
  std::string trouble;
  if (!configuration || configuration->empty()) {
    trouble = "it has no video stream";
  } else {
    const libcamera::StreamConfiguration& stream = configuration->at(0);
    bool readable = format_of_libcamera(stream.pixelFormat.fourcc()).has_value();
    for (const libcamera::PixelFormat& format : stream.formats().pixelformats()) {
      readable |= format.modifier() == 0 && format_of_libcamera(format.fourcc()).has_value();
    }
    if (!readable) trouble = "none of its formats can be read: it offers " + stream.pixelFormat.toString();
  }
  camera.release();
  return trouble;
}

}  // namespace

LibcameraSystem::LibcameraSystem() : parts_(std::make_unique<Parts>()) {
  setenv("LIBCAMERA_LOG_LEVELS", "*:FATAL", 0);
  begin();
}

LibcameraSystem::~LibcameraSystem() {
  end();
}

void LibcameraSystem::begin() {
  parts_->manager = std::make_unique<libcamera::CameraManager>();
  parts_->manager->cameraAdded.connect(parts_.get(), &Parts::see_camera);
  const int error = parts_->manager->start();
  trouble_.reset();
  if (error != 0) trouble_ = CameraTrouble{CameraCause::kFailed, "CameraManager::start", -error};
}

void LibcameraSystem::end() {
  if (!trouble_) parts_->manager->stop();
  delete parts_->milestone.exchange(nullptr);  // its thread has ended
  parts_->manager.reset();
}

std::optional<CameraTrouble> LibcameraSystem::trouble() {
  const std::lock_guard lock(parts_->mutex);
  return trouble_;
}

std::vector<LibcameraListing> LibcameraSystem::list() {
  std::vector<LibcameraListing> listings;
  const std::lock_guard lock(parts_->mutex);
  if (trouble_) return listings;
  for (const std::shared_ptr<libcamera::Camera>& camera : parts_->manager->cameras()) {
    listings.push_back({camera->id(), model_of(*camera),
                        parts_->is_taken(camera.get()) ? "it is in use" : trouble_with(*camera)});
  }
  return listings;
}

std::string LibcameraSystem::version() {
  return libcamera::CameraManager::version();
}

std::variant<std::shared_ptr<libcamera::Camera>, CameraTrouble> LibcameraSystem::take(std::string_view name) {
  const std::lock_guard lock(parts_->mutex);
  if (trouble_) return *trouble_;
  const std::vector<std::shared_ptr<libcamera::Camera>> cameras = parts_->manager->cameras();
  std::vector<LibcameraListing> names;
  for (const std::shared_ptr<libcamera::Camera>& camera : cameras) {
    names.push_back({camera->id(), model_of(*camera), {}});
  }
  const auto found = find_camera(names, name);
  if (const auto* trouble = std::get_if<CameraTrouble>(&found)) return *trouble;
  const std::shared_ptr<libcamera::Camera>& camera = cameras[std::get<std::size_t>(found)];
  if (parts_->is_taken(camera.get())) return CameraTrouble{CameraCause::kBusy, "Camera::acquire", 0};
  if (const int error = camera->acquire()) {
    return CameraTrouble{error == -ENODEV ? CameraCause::kMissing : CameraCause::kBusy, "Camera::acquire",
                         -error};
  }
  parts_->taken.push_back(camera.get());
  return camera;
}

void LibcameraSystem::put_back(std::shared_ptr<libcamera::Camera> camera, bool gone) {
  const std::lock_guard lock(parts_->mutex);
  camera->release();
  std::erase(parts_->taken, camera.get());
  camera.reset();
  if (!gone || !parts_->taken.empty()) return;
  end();
  begin();
}

void LibcameraSystem::settle() {
  if (Milestone* milestone = parts_->milestone.load()) {
    milestone->invokeMethod(&Milestone::pass, libcamera::ConnectionTypeBlocking);
  }
}

}  // namespace cupola
