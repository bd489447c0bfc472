// The only place that knows what time it is.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <span>
#include <vector>

namespace cupola {

class Clock {
 public:
  virtual ~Clock() = default;
  // CLOCK_MONOTONIC, as V4L2 and KMS stamp their frames.
  virtual std::chrono::nanoseconds now() noexcept = 0;
  // Returns at `deadline` or at once if it is past.
  virtual void sleep_until(std::chrono::nanoseconds deadline) noexcept = 0;
  // True as soon as one of at most 16 `descriptors` has something to read, an event or an error; false at
  // `deadline`. Asks once at least, also when the deadline is past. Negative descriptors are passed over.
  virtual bool wait(std::span<const int> descriptors, std::chrono::nanoseconds deadline) noexcept = 0;
};

// The machine's own clock.
class MonotonicClock final : public Clock {
 public:
  std::chrono::nanoseconds now() noexcept override;
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  bool wait(std::span<const int> descriptors, std::chrono::nanoseconds deadline) noexcept override;
};

// A clock that moves only when somebody sleeps, waits or says so; one thread. Fake devices wake those who
// wait for them by alarms, so that the same steps happen in the same order every time.
class FakeClock final : public Clock {
 public:
  std::chrono::nanoseconds now() noexcept override { return now_; }
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override {
    if (deadline > now_) now_ = deadline;
  }
  // Moves to the first alarm among `descriptors` or to the deadline. Real descriptors are asked without
  // waiting.
  bool wait(std::span<const int> descriptors, std::chrono::nanoseconds deadline) noexcept override;
  void advance(std::chrono::nanoseconds step) { now_ += step; }

  // A stand-in for a descriptor: "has something to read" from the alarm's time on.
  int add_alarm();
  void set_alarm(int alarm, std::chrono::nanoseconds when) noexcept;  // nanoseconds::max(): not in sight

 private:
  std::chrono::nanoseconds* alarm(int descriptor) noexcept;

  std::chrono::nanoseconds now_{0};
  std::vector<std::chrono::nanoseconds> alarms_;
};

}  // namespace cupola
