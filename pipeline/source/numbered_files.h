// Names of numbered files, one sequence a view: patterns, and finding out what a folder holds.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cupola {

// A pattern is a path in which
//   {view}       stands for a view's name,
//   {letter}, %c stand for its letter in the field: l f r b t d, b the back and d the bottom,
//   %06d, %d     stand, once and in the file's own name, for the number, with at least so many digits.

inline bool has_number(std::string_view pattern) {
  return pattern.find('%') != std::string_view::npos;
}
bool has_view(std::string_view pattern);

// The pattern for one view, its number still open. Throws InputError for a view without a letter.
std::string pattern_of_view(std::string_view pattern, std::string_view view);

// The file with that number; throws InputError where the pattern has no number or two, or anything else after
// %.
std::string numbered_file(std::string_view pattern, std::int64_t number);

struct NumberRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
  friend bool operator==(const NumberRange&, const NumberRange&) = default;
};

// The file numbers that all `patterns` (of views, see above) have; `in` and `out` limit them. Throws
// InputError naming the first missing file when there is a gap, when the patterns differ, or when `in` or
// `out` is not there.
NumberRange find_numbers(std::span<const std::string> patterns, std::optional<std::int64_t> in = {},
                         std::optional<std::int64_t> out = {});

// The pattern by which `folder` holds numbered pictures of every one of `views`: front/000001.png,
// name_front_000001.png, frame_f_0001.png and the like. Throws InputError when there is none or more than
// one.
std::string find_pattern(const std::filesystem::path& folder, std::span<const std::string> views);

}  // namespace cupola
