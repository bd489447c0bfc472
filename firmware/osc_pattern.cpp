// Not liblo's lo_pattern_match(): its * passes over slashes, and several of them take it exponential time.
// SPDX-License-Identifier: MIT
#include "firmware/osc_pattern.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cstdint>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

// Bit n: the pattern so far matches the part's first n characters. All ways are followed at once, so that
// there is nothing to go back to.
using Places = std::uint64_t;

// What stands between pattern[from], which opens it, and its other half.
std::string_view enclosed(std::string_view pattern, std::size_t from, char closes) {
  const std::size_t end = pattern.find(closes, from + 1);
  if (end == pattern.npos) {
    throw InputError(fmt::format("a pattern with a {} that no {} follows", pattern[from], closes));
  }
  return pattern.substr(from + 1, end - from - 1);
}

// "abc", "a-z" or "!abc"; a ! elsewhere and a - at an end mean themselves.
bool in_set(std::string_view set, char c) {
  const bool others = set.starts_with('!');
  if (others) set.remove_prefix(1);
  const auto code = [](char one) { return static_cast<unsigned char>(one); };
  bool found = false;
  while (!set.empty()) {
    const bool range = set.size() >= 3 && set[1] == '-';
    const auto [least, most] = std::minmax({code(set[0]), code(set[range ? 2 : 0])});
    found = found || (code(c) >= least && code(c) <= most);
    set.remove_prefix(range ? 3 : 1);
  }
  return found != others;
}

// One character further wherever `takes` takes the next one.
template <class Takes>
Places step(Places at, std::string_view part, Takes takes) {
  Places next = 0;
  for (std::size_t i = 0; i < part.size(); ++i) {
    if ((at >> i & 1U) != 0 && takes(part[i])) next |= Places{2} << i;
  }
  return next;
}

// By any of the texts between the commas.
Places step_by_one_of(Places at, std::string_view part, std::string_view texts) {
  Places next = 0;
  for (;;) {
    const std::string_view text = texts.substr(0, texts.find(','));
    Places here = at;
    for (const char wanted : text) here = step(here, part, [&](char c) { return c == wanted; });
    next |= here;
    if (text.size() == texts.size()) return next;
    texts.remove_prefix(text.size() + 1);
  }
}

}  // namespace

bool is_osc_pattern(std::string_view text) {
  return text.find_first_of("?*[]{}") != text.npos;
}

bool osc_matches(std::string_view pattern, std::string_view part) {
  assert(part.size() <= kLongestOscPart);
  if (pattern.size() > kLongestOscPattern) {
    throw InputError(fmt::format("a pattern of over {} characters", kLongestOscPattern));
  }
  const Places all = (Places{2} << part.size()) - 1;
  Places at = 1;
  for (std::size_t i = 0; i < pattern.size(); ++i) {
    const char sign = pattern[i];
    if (sign == '*') {
      at = (at | (Places{0} - at)) & all;  // from the first place on
    } else if (sign == '?') {
      at = at << 1 & all;
    } else if (sign == '[') {
      const std::string_view set = enclosed(pattern, i, ']');
      at = step(at, part, [&](char c) { return in_set(set, c); });
      i += set.size() + 1;
    } else if (sign == '{') {
      const std::string_view texts = enclosed(pattern, i, '}');
      at = step_by_one_of(at, part, texts);
      i += texts.size() + 1;
    } else if (sign == ']' || sign == '}') {
      throw InputError(fmt::format("a pattern with a {} that closes nothing", sign));
    } else {
      at = step(at, part, [&](char c) { return c == sign; });
    }
  }
  return (at >> part.size() & 1U) != 0;
}

}  // namespace cupola
