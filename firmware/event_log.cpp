// A ring of fixed lines.
// SPDX-License-Identifier: MIT
#include "firmware/event_log.h"

#include <algorithm>
#include <cstdio>

namespace cupola {

void EventLog::note(std::string_view text) noexcept {
  if (!mutex_.try_lock()) return;
  Kept& kept = kept_[static_cast<std::size_t>(count_) % kLines];
  kept.number = ++count_;
  kept.at = wall_time();
  kept.length = std::min(text.size(), kLongest);
  std::copy_n(text.data(), kept.length, kept.text.data());
  mutex_.unlock();
}

void EventLog::say(std::string_view text) noexcept {
  std::fprintf(stderr, "cupola: %.*s\n", static_cast<int>(text.size()), text.data());
  note(text);
}

std::vector<EventLog::Line> EventLog::lines() const {
  std::vector<Line> lines;
  lines.reserve(kLines);
  const std::lock_guard lock(mutex_);
  for (std::size_t i = 0; i < kLines; ++i) {
    const Kept& kept = kept_[(static_cast<std::size_t>(count_) + i) % kLines];
    if (kept.number > 0) lines.push_back({kept.number, kept.at, std::string(kept.text.data(), kept.length)});
  }
  return lines;
}

}  // namespace cupola
