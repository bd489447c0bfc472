// Lines come through a queue without locks, and are sorted in by those who read.
// SPDX-License-Identifier: MIT
#include "firmware/event_log.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <utility>

namespace cupola {

std::string utc_text(WallTime at) {
  using std::chrono::floor;
  const auto second = floor<std::chrono::seconds>(at);
  const auto thousandths = floor<std::chrono::milliseconds>(at - second).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(second), thousandths);
}

void EventLog::add(Severity severity, Topic topic, std::string_view text) noexcept {
  Coming line{wall_time(), severity, topic, std::min(text.size(), kLongest), {}};
  std::copy_n(text.data(), line.length, line.text.data());
  if (!coming_.push(line)) left_out_.fetch_add(1, std::memory_order_relaxed);
  if (SideWork* reader = reader_.load()) reader->ring();
}

void EventLog::keep(Line line) {
  line.number = ++count_;
  kept_.push_back(std::move(line));
  if (kept_.size() > kLines) kept_.pop_front();
}

std::vector<EventLog::Line> EventLog::lines(std::int64_t after) {
  const std::lock_guard lock(mutex_);
  while (const auto line = coming_.take())
    keep({0, line->at, line->severity, line->topic, std::string(line->text.data(), line->length)});
  if (const std::int64_t left_out = left_out_.exchange(0)) {
    keep({0, wall_time(), Severity::kWarning, Topic::kMachine,
          fmt::format("{} lines of the log came too fast to be kept", left_out)});
  }
  std::vector<Line> lines;
  for (const Line& line : kept_) {
    if (line.number > after) lines.push_back(line);
  }
  return lines;
}

}  // namespace cupola
