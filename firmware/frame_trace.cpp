// The ring as text.
// SPDX-License-Identifier: MIT
#include "firmware/frame_trace.h"

#include <fmt/format.h>

#include <algorithm>
#include <iterator>

namespace cupola {
namespace {

struct Taken {
  std::int64_t begin, end, count;
  TraceWhat what;
};

constexpr const char* kNames[] = {"frame", "faces",   "warp", "present",
                                  "late",  "dropped", "cue",  "decoded ahead"};

void write(const Taken& taken, std::string& text) {
  const char* name = kNames[static_cast<std::size_t>(taken.what)];
  const double at = 1e-3 * static_cast<double>(taken.begin);
  const auto into = std::back_inserter(text);
  if (taken.what == TraceWhat::kAhead) {
    fmt::format_to(into, R"(,{{"name":"{}","ph":"C","pid":1,"ts":{:.3f},"args":{{"frames":{}}}}})", name, at,
                   taken.count);
  } else if (taken.what >= TraceWhat::kLate) {
    const char* counted = taken.what == TraceWhat::kCue ? "cue" : "frames";
    fmt::format_to(into,
                   R"(,{{"name":"{}","ph":"i","s":"t","pid":1,"tid":1,"ts":{:.3f},"args":{{"{}":{}}}}})",
                   name, at, counted, taken.count);
  } else {
    fmt::format_to(
        into, R"(,{{"name":"{}","ph":"X","pid":1,"tid":1,"ts":{:.3f},"dur":{:.3f},"args":{{"frame":{}}}}})",
        name, at, 1e-3 * static_cast<double>(taken.end - taken.begin), taken.count);
  }
}

}  // namespace

std::string FrameTrace::json() const {
  std::vector<Taken> all;
  all.reserve(kMarks);
  const std::uint64_t added = added_.load(std::memory_order_acquire);
  for (std::uint64_t number = added - std::min<std::uint64_t>(added, kMarks); number < added; ++number) {
    const Mark& mark = marks_[number % kMarks];
    if (mark.number.load(std::memory_order_acquire) != number + 1) continue;
    const std::int64_t begin = mark.begin.load(std::memory_order_acquire);
    const std::int64_t end = mark.end.load(std::memory_order_acquire);
    const std::int64_t count = mark.count.load(std::memory_order_acquire);
    if (mark.number.load(std::memory_order_relaxed) != number + 1) continue;
    all.push_back({begin, end, count >> 8, static_cast<TraceWhat>(count & 0xff)});
  }
  std::int64_t newest = 0;
  for (const Taken& taken : all) newest = std::max(newest, taken.end);
  const std::int64_t oldest = newest - std::chrono::nanoseconds(kLongest).count();
  std::string text =
      R"({"displayTimeUnit":"ms","traceEvents":[{"name":"process_name","ph":"M","pid":1,"args":{"name":"cupola"}},)"
      R"({"name":"thread_name","ph":"M","pid":1,"tid":1,"args":{"name":"frame loop"}})";
  bool whole = false;  // from the first frame on, never from within one
  for (const Taken& taken : all) {
    whole = whole || (taken.what == TraceWhat::kFrame && taken.begin >= oldest);
    if (whole) write(taken, text);
  }
  return text + "]}\n";
}

}  // namespace cupola
