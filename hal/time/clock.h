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

  // A descriptor for wait() that has something to read from a time on, once it is set: for devices whose
  // frames come by the clock. Not in sight at first. The clock's own; throws std::system_error when there is
  // none left.
  virtual int add_alarm() = 0;
  // nanoseconds::max(): not in sight.
  virtual void set_alarm(int alarm, std::chrono::nanoseconds when) noexcept = 0;
};

// The machine's own clock. Its alarms are the thread's that adds and sets them.
class MonotonicClock final : public Clock {
 public:
  MonotonicClock() = default;
  ~MonotonicClock() override;
  MonotonicClock(const MonotonicClock&) = delete;
  MonotonicClock& operator=(const MonotonicClock&) = delete;

  std::chrono::nanoseconds now() noexcept override;
  void sleep_until(std::chrono::nanoseconds deadline) noexcept override;
  bool wait(std::span<const int> descriptors, std::chrono::nanoseconds deadline) noexcept override;
  int add_alarm() override;
  void set_alarm(int alarm, std::chrono::nanoseconds when) noexcept override;

 private:
  std::vector<int> timers_;  // timerfds
};

// A clock that moves only when somebody sleeps, waits or says so; one thread. The same steps happen in the
// same order every time.
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
  int add_alarm() override;  // no real descriptor
  void set_alarm(int alarm, std::chrono::nanoseconds when) noexcept override;

 private:
  std::chrono::nanoseconds* alarm(int descriptor) noexcept;

  std::chrono::nanoseconds now_{0};
  std::vector<std::chrono::nanoseconds> alarms_;
};

}  // namespace cupola
