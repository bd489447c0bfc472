// What happened lately: the last lines, for whoever asks; trouble goes to standard error as well.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <mutex>
#include <string>
#include <string_view>
#include <vector>

#include "hal/time/wall_time.h"

namespace cupola {

// Any thread. Allocates nothing but in lines().
class EventLog {
 public:
  static constexpr std::size_t kLines = 256;
  static constexpr std::size_t kLongest = 240;  // bytes; what is longer is cut

  struct Line {
    std::int64_t number = 0;  // counts from 1: a gap is what was written over or left out
    WallTime at;
    std::string text;
  };

  // Keeps the line. Does not wait: where another thread is at it just now, the line is left out.
  void note(std::string_view text) noexcept;
  // Keeps it and writes "cupola: TEXT" to standard error, always.
  void say(std::string_view text) noexcept;
  // Oldest first.
  std::vector<Line> lines() const;

 private:
  struct Kept {
    std::int64_t number = 0;  // 0: none yet
    WallTime at;
    std::size_t length = 0;
    std::array<char, kLongest> text{};
  };
  mutable std::mutex mutex_;
  std::int64_t count_ = 0;
  std::array<Kept, kLines> kept_;  // a ring
};

}  // namespace cupola
