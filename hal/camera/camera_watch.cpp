// Two things at once: whether frames flow (state_), and whether the device was started (running_).
// SPDX-License-Identifier: MIT
#include "hal/camera/camera_watch.h"

#include <algorithm>
#include <utility>

#include "hal/camera/camera_planes.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr nanoseconds kUnknownPeriod = std::chrono::milliseconds(40);
constexpr nanoseconds kFirstFrame = std::chrono::seconds(2);  // cameras take that long to begin
constexpr int kMostAtOnce = 32;  // damaged frames: no more than there are buffers
constexpr std::uint32_t kBackwards = std::uint32_t{1} << 31;

}  // namespace

CameraWatch::CameraWatch(Camera& camera, CameraSetup setup, Clock& clock, nanoseconds patience,
                         Starting starting)
    : camera_(camera), setup_(std::move(setup)), clock_(clock), patience_(patience) {
  if (starting == Starting::kOnAThread) chores_.emplace(camera);
}

CameraWatch::~CameraWatch() {
  chores_.reset();
  camera_.stop();
}

CameraWatch::Poll CameraWatch::poll(CameraFrame& frame) noexcept {
  if (!running_) {
    if (clock_.now() < next_start_) return Poll::kNothing;
    CameraTrouble trouble;
    const Start started = start(trouble);
    if (started == Start::kUnderWay) return Poll::kNothing;
    if (started == Start::kFailed) return report(trouble);
    turned_ = std::any_of(dials_.begin(), dials_.end(), [](const auto& dial) { return !dial.name.empty(); });
  }
  set_dials();
  if (first_) {
    frame = *first_;
    first_.reset();
    ++counts_.frames;
    return Poll::kFrame;
  }
  for (int i = 0; i < kMostAtOnce; ++i) {
    CameraTrouble trouble;
    switch (camera_.poll(frame, trouble)) {
      case CameraPoll::kNothing:
        return listen();
      case CameraPoll::kLost:
        return lose(trouble);
      case CameraPoll::kDamaged:
        ++counts_.damaged;
        unwrap(frame.sequence);
        continue;
      case CameraPoll::kFrame:
        break;
    }
    if (!fits(frame, mode_)) return lose({CameraCause::kChanged, "frame", 0});
    const std::uint64_t before = count_ ? sequence_ : 0;
    frame.sequence = unwrap(frame.sequence);
    if (!is_whole(frame)) {
      ++counts_.damaged;
      camera_.give_back(frame);
      continue;
    }
    frame.captured_at = sane_time(frame.captured_at, before > 0 ? frame.sequence - before : 0);
    alive_at_ = clock_.now();
    reported_ = false;
    if (std::exchange(state_, CameraState::kStreaming) == CameraState::kLost) {
      first_ = frame;
      return Poll::kBack;
    }
    ++counts_.frames;
    return Poll::kFrame;
  }
  return listen();
}

void CameraWatch::give_back(const CameraFrame& frame) noexcept {
  if (running_ && frame.sequence >= run_begins_) camera_.give_back(frame);
}

void CameraWatch::stop() noexcept {
  if (chores_) chores_->finish();
  camera_.stop();
  running_ = false;
  reported_ = false;
  first_.reset();
  state_ = CameraState::kLost;
  next_start_ = nanoseconds::min();
}

void CameraWatch::set_setup(CameraSetup setup) {
  stop();
  setup_ = std::move(setup);
  agreed_ = false;
}

int CameraWatch::descriptor() const noexcept {
  if (running_) return camera_.descriptor();
  return chores_ && chores_->starting() ? chores_->descriptor() : -1;
}

nanoseconds CameraWatch::deadline() const noexcept {
  if (chores_ && chores_->starting()) return nanoseconds::max();
  if (!running_) return next_start_;
  return first_ ? alive_at_ : silence_ends();
}

// What came of a start; none: it is under way.
std::optional<CameraStart> CameraWatch::begun() noexcept {
  if (!chores_) return camera_.start(setup_);
  if (!chores_->starting()) chores_->begin_start(setup_);
  return chores_->take_start();
}

void CameraWatch::turn(Dial dial, double value) noexcept {
  constexpr std::array<const char*, CameraChores::kMostControls> kNames = {"exposure", "gain", "frame_time"};
  const auto d = static_cast<std::size_t>(dial);
  dials_[d].name = kNames[d];
  dials_[d].value = value;
  turned_ = true;
}

void CameraWatch::set_dials() noexcept {
  if (!turned_ || (chores_ && chores_->setting())) return;
  turned_ = false;
  if (chores_) return chores_->begin_controls(dials_);
  for (const CameraControl& dial : dials_) {
    if (!dial.name.empty()) camera_.set_control(dial);
  }
}

CameraWatch::Start CameraWatch::start(CameraTrouble& trouble) noexcept {
  const std::optional<CameraStart> started = begun();
  if (!started) return Start::kUnderWay;
  const CameraMode* mode = std::get_if<CameraMode>(&*started);
  if (mode && is_as_agreed(*mode)) {
    mode_ = *mode;
    agreed_ = true;
    ++counts_.starts;
    running_ = true;
    alive_at_ = clock_.now();
    count_.reset();
    run_begins_ = any_ ? sequence_ + 1 : 0;
    clock_offset_ = 0;
    return Start::kDone;
  }
  if (mode) {
    camera_.stop();
    trouble = {CameraCause::kChanged, "mode", 0};
  } else {
    trouble = *std::get_if<CameraTrouble>(&*started);
    // It did what it is asked for before.
    if (agreed_ && trouble.cause == CameraCause::kUnsupported) trouble.cause = CameraCause::kChanged;
  }
  ++counts_.failed_starts;
  next_start_ = clock_.now() + period();
  return Start::kFailed;
}

bool CameraWatch::is_as_agreed(const CameraMode& mode) const noexcept {
  return !agreed_ || setup_.width == 0 ||
         (mode.format == mode_.format && mode.width == mode_.width && mode.height == mode_.height &&
          mode.crop == mode_.crop);
}

CameraWatch::Poll CameraWatch::lose(const CameraTrouble& trouble) noexcept {
  // Not stopped: lent frames stay readable until the next poll() starts it again.
  const nanoseconds now = clock_.now();
  next_start_ = state_ == CameraState::kStreaming ? now : now + period();
  running_ = false;
  if (!reported_) ++counts_.losses;
  return report(trouble);
}

CameraWatch::Poll CameraWatch::listen() noexcept {
  if (clock_.now() < silence_ends()) return Poll::kNothing;
  const CameraTrouble silent{CameraCause::kSilent, "", 0};
  if (!reported_ || trouble_.cause != CameraCause::kSilent) ++counts_.silences;
  if (state_ == CameraState::kStreaming || reported_) return lose(silent);
  // Started a moment ago: the bark is due, but the camera is left to begin.
  ++counts_.losses;
  return report(silent);
}

CameraWatch::Poll CameraWatch::report(const CameraTrouble& trouble) noexcept {
  if (!reported_ || trouble.cause != trouble_.cause)
    ++counts_.causes[static_cast<std::size_t>(trouble.cause)];
  trouble_ = trouble;
  state_ = CameraState::kLost;
  return std::exchange(reported_, true) ? Poll::kNothing : Poll::kLost;
}

std::uint64_t CameraWatch::unwrap(std::uint64_t sequence) noexcept {
  const auto count = static_cast<std::uint32_t>(sequence);
  if (!any_) {
    sequence_ = count;
  } else if (!count_) {
    ++sequence_;
  } else {
    // A counter that stands still or goes back says nothing about lost frames.
    std::uint32_t step = count - *count_;
    if (step == 0 || step >= kBackwards) step = 1;
    counts_.dropped += step - 1;
    sequence_ += step;
  }
  any_ = true;
  count_ = count;
  return sequence_;
}

// The device's own time where it lies between the last frame's and now; else the device's time with what its
// clock was found to be off by; else it stepped, and the frame gets the time at which it was expected, `gap`
// periods after the last one, or now (0).
nanoseconds CameraWatch::sane_time(nanoseconds captured_at, std::uint64_t gap) noexcept {
  const nanoseconds now = clock_.now();
  const bool first = stamp_ == nanoseconds::min();
  const nanoseconds latest = now + period();  // some drivers stamp the end of a frame as they begin it
  const auto is_sane = [&](nanoseconds time) { return time > stamp_ && time <= latest; };
  nanoseconds time = captured_at;
  if (is_sane(time)) {
    clock_offset_ = 0;
  } else {
    const auto raw = static_cast<std::uint64_t>(captured_at.count());
    time = nanoseconds(static_cast<std::int64_t>(raw + clock_offset_));
    if (clock_offset_ != 0 && time > now && time <= now + patience_) {
      // The frame that the offset was found with had come late.
      clock_offset_ -= static_cast<std::uint64_t>((time - now).count());
      time = now;
    } else if (clock_offset_ == 0 || !is_sane(time)) {
      ++counts_.clock_steps;
      const auto periods = static_cast<std::int64_t>(std::min<std::uint64_t>(gap, 1000));
      time = periods == 0 ? now : std::min(now, stamp_ + periods * period());
      clock_offset_ = static_cast<std::uint64_t>(time.count()) - raw;
    }
  }
  time = std::min(time, now);
  if (!first) time = std::max(time, stamp_ + nanoseconds(1));
  stamp_ = time;
  return time;
}

nanoseconds CameraWatch::period() const noexcept {
  if (mode_.rate < 1.0) return kUnknownPeriod;
  return nanoseconds(static_cast<std::int64_t>(1e9 / mode_.rate));
}

nanoseconds CameraWatch::silence_ends() const noexcept {
  const bool begins = state_ == CameraState::kLost && reported_;
  return alive_at_ + (begins ? std::max(patience_, kFirstFrame) : patience_);
}

}  // namespace cupola
