// Each call goes to the device first; what it answered is said to the recorder.
// SPDX-License-Identifier: MIT
#include "hal/camera/recording_camera.h"

#include <utility>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

// Devices' clocks may say anything: modulo 2^64.
nanoseconds since(nanoseconds begin, nanoseconds time) {
  return nanoseconds(static_cast<std::int64_t>(static_cast<std::uint64_t>(time.count()) -
                                               static_cast<std::uint64_t>(begin.count())));
}

}  // namespace

RecordingCamera::RecordingCamera(std::unique_ptr<Camera> device, Clock& clock, nanoseconds begin,
                                 std::unique_ptr<CameraRecorder> recorder)
    : device_(std::move(device)), clock_(clock), begin_(begin), recorder_(std::move(recorder)) {}

RecordingCamera::~RecordingCamera() {
  stop();
}

CameraRecord RecordingCamera::record(RecordKind kind) const noexcept {
  CameraRecord made;
  made.kind = kind;
  made.seen_at = since(begin_, clock_.now());
  return made;
}

std::variant<CameraMode, CameraTrouble> RecordingCamera::start(const CameraSetup& setup) noexcept {
  stop();
  auto answer = device_->start(setup);
  const CameraMode* mode = std::get_if<CameraMode>(&answer);
  CameraRecord said = record(mode ? RecordKind::kStarted : RecordKind::kRefused);
  if (mode) {
    said.mode = *mode;
  } else {
    said.trouble = std::get<CameraTrouble>(answer);
  }
  recorder_->say(said);
  return answer;
}

void RecordingCamera::stop() noexcept {
  recorder_->take_all_back();
  withheld_.reset();
  device_->stop();
}

CameraPoll RecordingCamera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  return_copied();
  const CameraPoll answer = device_->poll(frame, trouble);
  if (answer == CameraPoll::kNothing) return answer;
  CameraRecord said = record(answer == CameraPoll::kFrame     ? RecordKind::kFrame
                             : answer == CameraPoll::kDamaged ? RecordKind::kDamaged
                                                              : RecordKind::kLost);
  if (answer == CameraPoll::kFrame) {
    said.frame = frame;
    said.frame.captured_at = since(begin_, frame.captured_at);
  } else if (answer == CameraPoll::kDamaged) {
    said.frame.sequence = frame.sequence;
  } else {
    said.trouble = trouble;
  }
  recorder_->say(said);
  return answer;
}

void RecordingCamera::give_back(const CameraFrame& frame) noexcept {
  if (recorder_->take_back(frame.buffer)) return device_->give_back(frame);
  // There is one at most: the recorder copies one frame at a time.
  return_copied();
  withheld_ = frame;
}

void RecordingCamera::return_copied() noexcept {
  if (withheld_ && recorder_->take_back(withheld_->buffer))
    device_->give_back(*std::exchange(withheld_, std::nullopt));
}

}  // namespace cupola
