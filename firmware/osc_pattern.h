// The address patterns of OSC 1.0: ?, *, [a-z], [!abc] and {go,next}.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <string_view>

namespace cupola {

constexpr std::size_t kLongestOscPattern = 128;  // characters
constexpr std::size_t kLongestOscPart = 63;      // of an address, between two slashes

// Whether any sign in the text has a meaning of its own in patterns.
bool is_osc_pattern(std::string_view text);

// Whether `pattern` matches `part`, of at most kLongestOscPart characters and no slash. Takes any bytes, and
// at most so many steps as the lengths multiplied. Throws InputError for a bracket or a brace without its
// other half and for longer patterns.
bool osc_matches(std::string_view pattern, std::string_view part);

}  // namespace cupola
