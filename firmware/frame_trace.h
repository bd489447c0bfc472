// What the frame loop did in the last minute, frame by frame, for Perfetto.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <string>
#include <vector>

namespace cupola {

enum class TraceWhat : std::uint8_t {
  kFrame,  // and within it, one after the other ...
  kFaces,
  kWarp,
  kPresent,
  kLate,  // instants
  kDropped,
  kCue,    // an instant: another one began
  kAhead,  // a level: frames that are decoded and not yet shown
};

// A ring that the loop's thread writes without waiting and whoever asks reads meanwhile: a mark that is
// written over just then is left out. Allocates at once, and in json().
class FrameTrace {
 public:
  static constexpr std::size_t kMarks = 65536;  // 4 a frame: a minute at 240 Hz
  static constexpr std::chrono::seconds kLongest{60};

  FrameTrace() : marks_(kMarks) {}
  // `count`: the frame's number; how many were late or dropped; the cue's number, from 1; the level.
  void add(TraceWhat what, std::chrono::nanoseconds begin, std::chrono::nanoseconds end,
           std::int64_t count) noexcept {
    const std::uint64_t number = added_.load(std::memory_order_relaxed);
    Mark& mark = marks_[number % kMarks];
    mark.number.store(0, std::memory_order_relaxed);
    // Whoever sees any of these sees the 0 above, or what follows.
    mark.begin.store(begin.count(), std::memory_order_release);
    mark.end.store(end.count(), std::memory_order_release);
    mark.count.store(count << 8 | static_cast<std::int64_t>(what), std::memory_order_release);
    mark.number.store(number + 1, std::memory_order_release);
    added_.store(number + 1, std::memory_order_release);
  }
  // The last minute in Chrome's JSON trace format; times in microseconds of the loop's clock.
  std::string json() const;

 private:
  struct Mark {
    std::atomic<std::uint64_t> number{0};  // counts from 1; 0: none, or being written
    std::atomic<std::int64_t> begin{0};    // ns
    std::atomic<std::int64_t> end{0};
    std::atomic<std::int64_t> count{0};  // above the lowest byte, which says what
  };
  std::vector<Mark> marks_;
  std::atomic<std::uint64_t> added_{0};
};

}  // namespace cupola
