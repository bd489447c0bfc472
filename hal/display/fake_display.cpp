// Two buffers that change places at every flip: nothing is copied.
// SPDX-License-Identifier: MIT
#include "hal/display/fake_display.h"

#include <algorithm>
#include <stdexcept>
#include <utility>

namespace cupola {

FakeDisplay::FakeDisplay(Clock& clock, int width, int height, std::chrono::nanoseconds period)
    : clock_(clock), width_(width), height_(height), period_(period), last_flip_(clock.now()) {
  if (width < 1 || height < 1 || width > 65535 || height > 65535 || period.count() < 1) {
    throw std::runtime_error("fake display: expected sides from 1 to 65535 and a period above 0");
  }
  for (Memory& each : memory_)
    each.words.resize(static_cast<std::size_t>(width) * static_cast<std::size_t>(height));
}

bool FakeDisplay::prepare_nv12(ScanoutColour colour) {
  if (!can_nv12_) return false;
  colour_ = colour;
  const auto stride = static_cast<std::size_t>((width_ + 1) / 2 * 2);
  for (Memory& each : memory_)
    each.nv12.resize(stride * static_cast<std::size_t>(height_ + (height_ + 1) / 2));
  return true;
}

DisplayBuffer FakeDisplay::buffer(std::size_t index) noexcept {
  Memory& memory = memory_[index];
  if (!memory.is_nv12) {
    return {reinterpret_cast<std::byte*>(memory.words.data()), std::ptrdiff_t{4} * width_, width_, height_};
  }
  const std::ptrdiff_t stride = (width_ + 1) / 2 * 2;
  return {memory.nv12.data(), stride, width_, height_, 0, memory.nv12.data() + stride * height_};
}

// What it held of the other format is forgotten.
DisplayBuffer FakeDisplay::back(bool nv12) noexcept {
  const bool held = std::exchange(memory_[back_].is_nv12, nv12) == nv12;
  DisplayBuffer back = buffer(back_);
  back.age = presents_ < 2 || !held ? 0 : 2;
  return back;
}

DisplayBuffer FakeDisplay::back_buffer() noexcept {
  return back(false);
}
DisplayBuffer FakeDisplay::back_nv12() noexcept {
  return memory_[back_].nv12.empty() ? DisplayBuffer{} : back(true);
}
DisplayBuffer FakeDisplay::front_buffer() noexcept {
  return buffer(1 - back_);
}

Presented FakeDisplay::present(std::chrono::nanoseconds when) noexcept {
  const Presented shown = repeat(when);
  if (shown.result == Present::kShown || shown.result == Present::kAway) {
    back_ = 1 - back_;
    ++presents_;
  }
  return shown;
}

Presented FakeDisplay::repeat(std::chrono::nanoseconds when) noexcept {
  if (fate_ != Present::kShown) {
    trouble_ = fate_ == Present::kLost ? "lost on demand" : "";
    return {fate_, clock_.now()};
  }
  const std::chrono::nanoseconds earliest = std::max(when, clock_.now());
  const std::int64_t periods =
      std::max<std::int64_t>(1, (earliest - last_flip_ + period_ - std::chrono::nanoseconds(1)) / period_);
  last_flip_ += periods * period_;
  clock_.sleep_until(last_flip_);
  for (; absence_ < absences_.size() && absences_[absence_].until <= last_flip_; ++absence_) {
    if (absences_[absence_].period_after.count() > 0) period_ = absences_[absence_].period_after;
  }
  if (absence_ < absences_.size() && absences_[absence_].from <= last_flip_) {
    trouble_ = "unplugged on demand";
    return {Present::kAway, last_flip_};
  }
  ++frames_;
  return {Present::kShown, last_flip_};
}

void FakeDisplay::set_absences(std::vector<Absence> one_after_the_other) {
  absences_ = std::move(one_after_the_other);
  absence_ = 0;
}

std::uint64_t FakeDisplay::front_hash() noexcept {
  std::uint64_t hash = 0xcbf29ce484222325U;
  for (const std::uint32_t word : memory_[1 - back_].words) hash = (hash ^ word) * 0x100000001b3U;
  return hash;
}

}  // namespace cupola
