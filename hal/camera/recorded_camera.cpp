// Walks through the records by the clock.
// SPDX-License-Identifier: MIT
#include "hal/camera/recorded_camera.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr CameraTrouble kEnd{CameraCause::kMissing, "the recording's end", 0};

bool is_start(RecordKind kind) {
  return kind == RecordKind::kStarted || kind == RecordKind::kRefused;
}

// Recorded times may be anything: modulo 2^64.
nanoseconds sum(nanoseconds a, nanoseconds b) {
  return nanoseconds(static_cast<std::int64_t>(static_cast<std::uint64_t>(a.count()) +
                                               static_cast<std::uint64_t>(b.count())));
}

}  // namespace

RecordedCamera::RecordedCamera(Clock& clock, ReplayTime& time, const std::filesystem::path& file)
    : clock_(clock), time_(time), recording_(file), alarm_(clock.add_alarm()) {}

std::variant<CameraMode, CameraTrouble> RecordedCamera::start(const CameraSetup&) noexcept {
  stop();
  while (next_ < recording_.size() && !is_start(recording_.at(next_).kind)) ++next_;
  if (next_ == recording_.size()) return kEnd;
  const CameraRecord record = recording_.at(next_++);
  if (!time_.begin) time_.begin = sum(clock_.now(), -record.seen_at);
  if (record.kind == RecordKind::kRefused) return record.trouble;
  running_ = true;
  wind_alarm();
  return record.mode;
}

void RecordedCamera::stop() noexcept {
  running_ = false;
  lost_.reset();
  clock_.set_alarm(alarm_, nanoseconds::max());
}

void RecordedCamera::pass_over_empty_starts() noexcept {
  std::size_t start = next_;
  for (std::size_t i = next_; i < recording_.size(); ++i) {
    const RecordKind kind = recording_.at(i).kind;
    if (is_start(kind)) start = i;
    if (kind != RecordKind::kFrame) continue;
    next_ = start;
    return;
  }
}

CameraPoll RecordedCamera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  if (!running_) return CameraPoll::kNothing;
  if (!lost_) {
    if (next_ == recording_.size()) return CameraPoll::kNothing;
    const CameraRecord record = recording_.at(next_);
    if (is_start(record.kind) || sum(*time_.begin, record.seen_at) > clock_.now())
      return CameraPoll::kNothing;
    ++next_;
    wind_alarm();
    if (record.kind != RecordKind::kLost) {
      frame = record.frame;
      frame.captured_at = sum(*time_.begin, frame.captured_at);
      frame.buffer = static_cast<int>(next_ % 32);
      return record.kind == RecordKind::kFrame ? CameraPoll::kFrame : CameraPoll::kDamaged;
    }
    lost_ = record.trouble;
    clock_.set_alarm(alarm_, nanoseconds(0));  // it goes on being lost
  }
  trouble = *lost_;
  return CameraPoll::kLost;
}

// For the next thing that it has to say by itself: starts are said when it is asked.
void RecordedCamera::wind_alarm() noexcept {
  nanoseconds when = nanoseconds::max();
  if (next_ < recording_.size()) {
    const CameraRecord record = recording_.at(next_);
    if (!is_start(record.kind)) when = sum(*time_.begin, record.seen_at);
  }
  clock_.set_alarm(alarm_, when);
}

}  // namespace cupola
