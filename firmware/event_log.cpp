// Lines come through a queue without locks, and are sorted in by those who read.
// SPDX-License-Identifier: MIT
#include "firmware/event_log.h"

#include <fmt/chrono.h>
#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <chrono>

namespace cupola {

std::string utc_text(WallTime at) {
  using std::chrono::floor;
  const auto second = floor<std::chrono::seconds>(at);
  const auto thousandths = floor<std::chrono::milliseconds>(at - second).count();
  return fmt::format("{:%Y-%m-%dT%H:%M:%S}.{:03}Z", fmt::gmtime(second), thousandths);
}

EventLog::Kept EventLog::made(Severity severity, Topic topic, std::string_view text) noexcept {
  Kept line{wall_time(), severity, topic, std::min(text.size(), kLongest), {}};
  std::copy_n(text.data(), line.length, line.text.data());
  return line;
}

void EventLog::add(Severity severity, Topic topic, std::string_view text) noexcept {
  if (!coming_.push(made(severity, topic, text))) left_out_.fetch_add(1, std::memory_order_relaxed);
  if (SideWork* reader = reader_.load()) reader->ring();
}

void EventLog::take_coming() noexcept {
  const auto keep = [&](const Kept& line) { kept_[static_cast<std::size_t>(++count_) % kLines] = line; };
  while (const auto line = coming_.take()) keep(*line);
  if (const std::int64_t left_out = left_out_.exchange(0)) {
    std::array<char, kLongest> words{};
    const auto end = fmt::format_to_n(words.data(), words.size(),
                                      "{} lines of the log came too fast to be kept", left_out);
    keep(made(Severity::kWarning, Topic::kMachine, {words.data(), end.size}));
  }
}

std::vector<EventLog::Line> EventLog::lines(std::int64_t after, Severity least) {
  const std::lock_guard lock(mutex_);
  take_coming();
  const std::int64_t lost = std::max<std::int64_t>(0, count_ - static_cast<std::int64_t>(kLines));
  std::vector<Line> lines;
  for (std::int64_t n = std::max(after, lost) + 1; n <= count_; ++n) {
    const Kept& line = kept_[static_cast<std::size_t>(n) % kLines];
    if (line.severity < least) continue;
    lines.push_back({n, line.at, line.severity, line.topic, std::string(line.text.data(), line.length)});
  }
  return lines;
}

}  // namespace cupola
