// Nothing happens behind the caller's back: each poll() catches up with the clock, frame by frame.
// SPDX-License-Identifier: MIT
#include "hal/camera/fake_camera.h"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <new>
#include <stdexcept>
#include <utility>

#include "hal/camera/camera_planes.h"

namespace cupola {

using std::chrono::nanoseconds;

FakeCamera::FakeCamera(FakeClock& clock, FakeCameraDevice device)
    : clock_(clock), device_(std::move(device)), alarm_(clock.add_alarm()) {
  if (device_.formats.empty() || device_.rate <= 0.0 || device_.height < 2) {
    throw std::runtime_error("fake camera: expected a format, a rate above 0 and two rows or more");
  }
}

namespace {

// Even sides, within the picture; all of it where that leaves nothing.
CameraArea crop_to(const CameraArea& wanted, int width, int height) {
  const int left = std::max(wanted.x, 0) / 2 * 2;
  const int top = std::max(wanted.y, 0) / 2 * 2;
  const int right = std::min((wanted.x + wanted.width + 1) / 2 * 2, width);
  const int bottom = std::min((wanted.y + wanted.height + 1) / 2 * 2, height);
  if (wanted.width <= 0 || left >= right || top >= bottom) return {0, 0, width, height};
  return {left, top, right - left, bottom - top};
}

bool is_known(const CameraControl& control) {
  return control.name == "exposure" || control.name == "gain" || control.name == "auto_exposure";
}

// Of the frame what lies inside the area.
void cut(CameraFrame& frame, const CameraArea& area) {
  frame.width = area.width;
  frame.height = area.height;
  for (int p = 0; p < plane_count(frame.format); ++p) {
    CameraPlane& plane = frame.planes[static_cast<std::size_t>(p)];
    const PlaneShape before = plane_shape(frame.format, p, area.x, area.y);
    const std::ptrdiff_t skipped = plane.stride * before.rows + before.row_bytes;
    plane.data += skipped;
    plane.bytes -= static_cast<std::size_t>(skipped);
  }
}

}  // namespace

std::variant<CameraMode, CameraTrouble> FakeCamera::start(const CameraSetup& setup) noexcept {
  stop();
  const nanoseconds now = clock_.now();
  if (!setup.device.empty() && setup.device != device_.name) {
    return CameraTrouble{CameraCause::kMissing, "name", ENODEV};
  }
  if (const auto trouble = refusal(now)) return *trouble;
  if (fault(CameraFault::kStartFails, now)) return CameraTrouble{CameraCause::kFailed, "start", EIO};
  if (!std::all_of(setup.controls.begin(), setup.controls.end(), is_known)) {
    return CameraTrouble{CameraCause::kUnsupported, "controls", EINVAL};
  }
  if (setup.buffers < 2 || setup.buffers > static_cast<int>(kMostBuffers)) {
    return CameraTrouble{CameraCause::kUnsupported, "buffers", EINVAL};
  }
  CameraMode mode;
  mode.format = device_.formats.front();
  const auto has = [this](CameraFormat format) { return std::ranges::count(device_.formats, format) > 0; };
  if (!setup.formats.empty()) {
    const auto wanted = std::ranges::find_if(setup.formats, has);
    if (wanted == setup.formats.end()) return CameraTrouble{CameraCause::kUnsupported, "format", EINVAL};
    mode.format = *wanted;
  }
  if (setup.width != 0 && (setup.width != device_.width || setup.height != device_.height)) {
    return CameraTrouble{CameraCause::kUnsupported, "size", EINVAL};
  }
  if (fault(CameraFault::kWrongFormat, now)) {
    mode.format = mode.format == CameraFormat::kGrey ? CameraFormat::kYuyv : CameraFormat::kGrey;
  }
  const int height = fault(CameraFault::kWrongSize, now) ? device_.height / 2 : device_.height;
  const bool crops = device_.crop != FakeCrop::kNone && mode.format != CameraFormat::kMjpeg;
  mode.crop = crop_to(crops ? setup.crop : CameraArea{}, device_.width, height);
  mode.width = device_.crop == FakeCrop::kZooms ? device_.width : mode.crop.width;
  mode.height = device_.crop == FakeCrop::kZooms ? height : mode.crop.height;
  mode.rate = setup.rate > 0.0 ? setup.rate : device_.rate;
  try {
    picture_.emplace(mode.format, device_.width, height, device_.number);
    memory_.resize(static_cast<std::size_t>(setup.buffers));
    for (auto& memory : memory_) {
      memory.resize(picture_->bytes());
      picture_->prepare(memory);
    }
  } catch (const std::exception&) {
    return CameraTrouble{CameraCause::kUnsupported, "size", ENOMEM};
  }
  mode_ = mode;
  places_.fill(Place::kDevice);
  readies_ = 0;
  counts_from_ = now;
  first_ = 0;
  period_ns_ = 1e9 / mode.rate * (1.0 + device_.drift_ppm * 1e-6);
  next_ = 0;
  sequence_ = device_.first_sequence;
  phase_ = Phase::kRunning;
  wind_alarm();
  return mode;
}

void FakeCamera::stop() noexcept {
  phase_ = Phase::kStopped;
  clock_.set_alarm(alarm_, nanoseconds::max());
}

CameraPoll FakeCamera::poll(CameraFrame& frame, CameraTrouble& trouble) noexcept {
  if (phase_ == Phase::kStopped) return CameraPoll::kNothing;
  if (phase_ == Phase::kLost) return lose(loss_, trouble);
  const nanoseconds now = clock_.now();
  if (const auto why = refusal(now)) return lose(*why, trouble);
  capture(now);
  if (readies_ == 0 || ready_[first_ready_].due > now) {
    wind_alarm();
    return CameraPoll::kNothing;
  }
  const Ready ready = ready_[first_ready_];
  first_ready_ = (first_ready_ + 1) % kMostBuffers;
  --readies_;
  if (ready.damaged) {
    places_[static_cast<std::size_t>(ready.buffer)] = Place::kDevice;
    frame.sequence = ready.sequence;
  } else {
    lend(ready, frame);
  }
  wind_alarm();
  return ready.damaged ? CameraPoll::kDamaged : CameraPoll::kFrame;
}

void FakeCamera::give_back(const CameraFrame& frame) noexcept {
  const auto index = static_cast<std::size_t>(frame.buffer);
  if (phase_ != Phase::kRunning || index >= memory_.size() || places_[index] != Place::kLent) return;
  capture(clock_.now());  // what came before it was given back cannot use it
  places_[index] = Place::kDevice;
}

bool FakeCamera::set_control(const CameraControl& control) noexcept {
  if (phase_ != Phase::kRunning) return false;
  if (control.name != "frame_time") return is_known(control);
  if (!(control.value > 0.0)) return false;
  capture(clock_.now());
  counts_from_ += nanoseconds(std::llround(period_ns_ * static_cast<double>(next_ - first_)));
  first_ = next_;
  period_ns_ = 1e3 * control.value * (1.0 + device_.drift_ppm * 1e-6);
  wind_alarm();
  return true;
}

void FakeCamera::begin_fault(CameraFault kind, std::int64_t amount) {
  device_.faults.push_back({kind, clock_.now(), nanoseconds::max(), amount});
  if (phase_ == Phase::kRunning) wind_alarm();
}

void FakeCamera::end_faults() {
  for (FakeFault& fault : device_.faults) fault.until = std::min(fault.until, clock_.now());
}

const FakeFault* FakeCamera::fault(CameraFault kind, nanoseconds when) const noexcept {
  for (const FakeFault& fault : device_.faults) {
    if (fault.kind == kind && fault.from <= when && when < fault.until) return &fault;
  }
  return nullptr;
}

// Spread evenly: of 100 frames in a row exactly as many as the fault says.
bool FakeCamera::hits(CameraFault kind, nanoseconds when) const noexcept {
  const FakeFault* found = fault(kind, when);
  if (!found) return false;
  const auto percent = static_cast<std::uint64_t>(std::clamp<std::int64_t>(found->amount, 0, 100));
  return (captured_ + 1) * percent / 100 != captured_ * percent / 100;
}

std::optional<CameraTrouble> FakeCamera::refusal(nanoseconds now) const noexcept {
  if (fault(CameraFault::kUnplugged, now)) return CameraTrouble{CameraCause::kMissing, "device", ENODEV};
  if (fault(CameraFault::kNoSignal, now)) return CameraTrouble{CameraCause::kNoSignal, "signal", ENOLINK};
  return std::nullopt;
}

nanoseconds FakeCamera::due(std::uint64_t frame) const noexcept {
  const double ideal = period_ns_ * static_cast<double>(frame + 1 - first_);
  std::int64_t late = 0;
  if (device_.jitter > nanoseconds(0)) {
    // splitmix64: the same lateness for the same frame of the same camera.
    std::uint64_t hash = (frame + 1) * 0x9e3779b97f4a7c15U + static_cast<std::uint64_t>(device_.number);
    hash = (hash ^ hash >> 30) * 0xbf58476d1ce4e5b9U;
    hash = (hash ^ hash >> 27) * 0x94d049bb133111ebU;
    hash ^= hash >> 31;
    late = static_cast<std::int64_t>(hash % static_cast<std::uint64_t>(device_.jitter.count()));
  }
  return counts_from_ + nanoseconds(static_cast<std::int64_t>(ideal) + late);
}

void FakeCamera::capture(nanoseconds now) noexcept {
  for (nanoseconds when = due(next_); when <= now; when = due(next_)) {
    ++next_;
    if (fault(CameraFault::kSilent, when)) continue;
    const std::uint32_t sequence = sequence_++;
    const bool dropped = hits(CameraFault::kDropped, when);
    const bool damaged = hits(CameraFault::kDamaged, when);
    ++captured_;
    if (dropped) continue;
    const auto end = places_.begin() + static_cast<std::ptrdiff_t>(memory_.size());
    const auto place = std::find(places_.begin(), end, Place::kDevice);
    if (place == end) continue;  // all are lent: the device has nowhere to put it
    *place = Place::kReady;
    ready_[(first_ready_ + readies_++) % kMostBuffers] = {static_cast<int>(place - places_.begin()), sequence,
                                                          damaged, when, when + device_.latency};
  }
}

void FakeCamera::lend(const Ready& ready, CameraFrame& frame) noexcept {
  auto& memory = memory_[static_cast<std::size_t>(ready.buffer)];
  places_[static_cast<std::size_t>(ready.buffer)] = Place::kLent;
  picture_->describe(memory.data(), picture_->draw(memory, ready.sequence), frame);
  if (device_.crop == FakeCrop::kCuts && mode_.format != CameraFormat::kMjpeg) cut(frame, mode_.crop);
  for (CameraPlane& plane : frame.planes) {
    if (fault(CameraFault::kWrongStride, ready.captured_at)) plane.stride /= 2;
    if (fault(CameraFault::kShort, ready.captured_at)) plane.bytes /= 2;
  }
  frame.buffer = ready.buffer;
  frame.sequence = ready.sequence;
  frame.captured_at = ready.captured_at;
  if (const FakeFault* step = fault(CameraFault::kTimestampStep, ready.captured_at)) {
    const auto stamp =
        static_cast<std::uint64_t>(frame.captured_at.count()) + static_cast<std::uint64_t>(step->amount);
    frame.captured_at = nanoseconds(static_cast<std::int64_t>(stamp));  // clocks wrap
  }
}

void FakeCamera::wind_alarm() noexcept {
  nanoseconds next = due(next_) + device_.latency;
  if (readies_ > 0) next = std::min(next, ready_[first_ready_].due);
  for (const FakeFault& fault : device_.faults) {
    const bool ends_stream = fault.kind == CameraFault::kUnplugged || fault.kind == CameraFault::kNoSignal;
    if (ends_stream && fault.until > clock_.now()) next = std::min(next, fault.from);
  }
  clock_.set_alarm(alarm_, next);
}

CameraPoll FakeCamera::lose(const CameraTrouble& why, CameraTrouble& trouble) noexcept {
  phase_ = Phase::kLost;
  loss_ = trouble = why;
  clock_.set_alarm(alarm_, nanoseconds(0));
  return CameraPoll::kLost;
}

}  // namespace cupola
