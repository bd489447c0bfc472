// The machine's monotonic clock with its timers, and the fake one's alarms.
// SPDX-License-Identifier: MIT
#include "hal/time/clock.h"

#include <algorithm>
#include <array>
#include <cassert>
#include <cerrno>
#include <ctime>
#include <system_error>

#include <poll.h>
#include <sys/timerfd.h>
#include <unistd.h>

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr std::size_t kMostDescriptors = 16;
constexpr int kFirstAlarm = 1 << 24;  // above every descriptor a process can have

timespec timespec_of(nanoseconds time) {
  const auto seconds = std::chrono::duration_cast<std::chrono::seconds>(time);
  timespec parts{};
  parts.tv_sec = seconds.count();
  parts.tv_nsec = (time - seconds).count();
  return parts;
}

// Waits for at most `longest`; true when there is something to read. -1 when interrupted by a signal.
int poll_for(std::span<const int> descriptors, nanoseconds longest) {
  assert(descriptors.size() <= kMostDescriptors);
  std::array<pollfd, kMostDescriptors> polled{};
  for (std::size_t i = 0; i < descriptors.size(); ++i) polled[i] = {descriptors[i], POLLIN | POLLPRI, 0};
  const timespec timeout = timespec_of(std::max(longest, nanoseconds(0)));
  return ppoll(polled.data(), descriptors.size(), &timeout, nullptr);
}

}  // namespace

nanoseconds MonotonicClock::now() noexcept {
  timespec time{};
  clock_gettime(CLOCK_MONOTONIC, &time);
  return std::chrono::seconds(time.tv_sec) + std::chrono::nanoseconds(time.tv_nsec);
}

void MonotonicClock::sleep_until(nanoseconds deadline) noexcept {
  if (deadline <= nanoseconds(0)) return;
  const timespec until = timespec_of(deadline);
  while (clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &until, nullptr) == EINTR) {
  }
}

bool MonotonicClock::wait(std::span<const int> descriptors, nanoseconds deadline) noexcept {
  for (;;) {
    const int ready = poll_for(descriptors, deadline - now());
    if (ready >= 0) return ready > 0;
    if (errno != EINTR) {  // no memory: time passes all the same
      sleep_until(deadline);
      return false;
    }
  }
}

MonotonicClock::~MonotonicClock() {
  for (const int timer : timers_) close(timer);
}

int MonotonicClock::add_alarm() {
  timers_.reserve(timers_.size() + 1);
  const int timer = timerfd_create(CLOCK_MONOTONIC, TFD_NONBLOCK | TFD_CLOEXEC);
  if (timer < 0) throw std::system_error(errno, std::generic_category(), "timerfd_create");
  timers_.push_back(timer);
  return timer;
}

// Setting it also takes back that it rang.
void MonotonicClock::set_alarm(int alarm, nanoseconds when) noexcept {
  itimerspec setting{};  // zero: never
  if (when != nanoseconds::max()) setting.it_value = timespec_of(std::max(when, nanoseconds(1)));
  [[maybe_unused]] const int set = timerfd_settime(alarm, TFD_TIMER_ABSTIME, &setting, nullptr);
  assert(set == 0);
}

bool FakeClock::wait(std::span<const int> descriptors, nanoseconds deadline) noexcept {
  std::array<int, kMostDescriptors> real{};
  std::size_t reals = 0;
  nanoseconds first = nanoseconds::max();
  for (const int descriptor : descriptors) {
    if (const nanoseconds* when = alarm(descriptor)) {
      first = std::min(first, *when);
    } else if (descriptor >= 0 && reals < real.size()) {
      real[reals++] = descriptor;
    }
  }
  if (reals > 0 && poll_for({real.data(), reals}, nanoseconds(0)) > 0) return true;
  const bool rings = first <= std::max(now_, deadline);
  sleep_until(rings ? first : deadline);
  return rings;
}

int FakeClock::add_alarm() {
  alarms_.push_back(nanoseconds::max());
  return kFirstAlarm + static_cast<int>(alarms_.size()) - 1;
}

void FakeClock::set_alarm(int descriptor, nanoseconds when) noexcept {
  nanoseconds* time = alarm(descriptor);
  assert(time);
  *time = when;
}

nanoseconds* FakeClock::alarm(int descriptor) noexcept {
  const auto index = static_cast<std::size_t>(descriptor - kFirstAlarm);
  return descriptor >= kFirstAlarm && index < alarms_.size() ? &alarms_[index] : nullptr;
}

}  // namespace cupola
