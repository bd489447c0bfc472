// What happened lately: the last lines, for whoever asks.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "firmware/bounded_queue.h"
#include "firmware/side_work.h"
#include "hal/time/wall_time.h"

namespace cupola {

enum class Severity : std::uint8_t {
  kInfo,     // as it should be
  kNotice,   // worth an operator's look
  kWarning,  // something is wrong
};
enum class Topic : std::uint8_t { kShow, kDisplay, kCameras, kSound, kControl, kMachine };

constexpr const char* name_of(Severity severity) {
  constexpr const char* kNames[] = {"info", "notice", "warning"};
  return kNames[static_cast<std::size_t>(severity)];
}
constexpr const char* name_of(Topic topic) {
  constexpr const char* kNames[] = {"show", "display", "cameras", "sound", "control", "machine"};
  return kNames[static_cast<std::size_t>(topic)];
}

// "2026-01-31T23:59:59.123Z".
std::string utc_text(WallTime at);

class EventLog {
 public:
  static constexpr std::size_t kLines = 256;    // that are kept
  static constexpr std::size_t kLongest = 240;  // bytes; what is longer is cut

  struct Line {
    std::int64_t number = 0;  // counts from 1, in the order of their coming
    WallTime at;
    Severity severity = Severity::kInfo;
    Topic topic = Topic::kShow;
    std::string text;
  };

  // Any thread; neither waits nor allocates. Of more than kComing lines that nobody has looked at yet those
  // beyond are left out, and counted by a line of their own.
  void info(Topic topic, std::string_view text) noexcept { add(Severity::kInfo, topic, text); }
  void notice(Topic topic, std::string_view text) noexcept { add(Severity::kNotice, topic, text); }
  void warn(Topic topic, std::string_view text) noexcept { add(Severity::kWarning, topic, text); }

  // Not the loop's. The lines kept that come after number `after` and are at least so severe, oldest first.
  // Allocates only where there are some.
  std::vector<Line> lines(std::int64_t after = 0, Severity least = Severity::kInfo);
  // Is rung after each line; null: nobody. Borrowed.
  void ring(SideWork* reader) noexcept { reader_.store(reader); }

 private:
  static constexpr std::size_t kComing = 64;
  struct Kept {
    WallTime at;
    Severity severity = Severity::kInfo;
    Topic topic = Topic::kShow;
    std::size_t length = 0;
    std::array<char, kLongest> text{};
  };
  static Kept made(Severity severity, Topic topic, std::string_view text) noexcept;
  void add(Severity severity, Topic topic, std::string_view text) noexcept;
  void take_coming() noexcept;

  BoundedQueue<Kept, kComing> coming_;
  std::atomic<std::int64_t> left_out_{0};
  std::atomic<SideWork*> reader_{nullptr};
  std::mutex mutex_;  // of those who read; the rest is theirs
  std::int64_t count_ = 0;
  std::array<Kept, kLines> kept_;  // a ring: line n is in n % kLines
};

}  // namespace cupola
