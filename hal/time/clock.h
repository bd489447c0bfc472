// The only place that knows what time it is.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>

namespace cupola {

class Clock {
 public:
  virtual ~Clock() = default;
  // CLOCK_MONOTONIC, as V4L2 and KMS stamp their frames.
  virtual std::chrono::nanoseconds now() noexcept = 0;
  // Returns at `deadline` or at once if it is past.
  virtual void sleep_until(std::chrono::nanoseconds deadline) noexcept = 0;
};

// The machine's own clock.
class MonotonicClock final : public Clock {
 public:
  std::chrono::nanoseconds now() noexcept override;
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
};

// A clock that moves only when somebody sleeps or says so; one thread.
class FakeClock final : public Clock {
 public:
  std::chrono::nanoseconds now() noexcept override { return now_; }
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override {
    if (deadline > now_) now_ = deadline;
  }
  void advance(std::chrono::nanoseconds step) { now_ += step; }

 private:
  std::chrono::nanoseconds now_{0};
};

}  // namespace cupola
