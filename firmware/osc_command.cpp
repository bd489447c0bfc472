// Values become the text that parse_command() takes.
// SPDX-License-Identifier: MIT
#include "firmware/osc_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "firmware/control_settings.h"
#include "firmware/osc_pattern.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

constexpr std::string_view kRoot = "cupola";

// Whether the value presses or switches on; none where it is no button's.
std::optional<bool> pressed(const OscValue& value) {
  if (const auto* flag = std::get_if<bool>(&value)) return *flag;
  if (const auto* whole = std::get_if<std::int64_t>(&value)) return *whole != 0;
  if (const auto* number = std::get_if<double>(&value)) return *number != 0.0;
  return std::nullopt;
}

// Into the log and messages as it is: one line, and nothing that a terminal obeys.
std::string printable(std::string_view text) {
  std::string shown(text);
  const auto control = [](char c) { return static_cast<unsigned char>(c) < ' ' || c == 127; };
  std::replace_if(shown.begin(), shown.end(), control, '?');
  return shown;
}

std::string text_of(std::string_view word, const OscValue& value, bool whole) {
  if (const auto* text = std::get_if<std::string>(&value)) return printable(*text);
  if (const auto* number = std::get_if<std::int64_t>(&value)) return fmt::format("{}", *number);
  if (const auto* number = std::get_if<double>(&value)) {
    return whole && std::abs(*number) < 1e6 ? fmt::format("{}", std::lround(*number))
                                            : fmt::format("{}", *number);
  }
  throw InputError(fmt::format("{}: expected numbers or texts, not a true, a false or an impulse", word));
}

// The one command that the pattern matches: what several do at once (play and pause) nobody means.
std::string_view word_of_pattern(std::string_view pattern) {
  std::vector<std::string_view> words(command_words().begin(), command_words().end());
  words.push_back(kOscStatus);
  std::erase_if(words, [&](std::string_view word) { return !osc_matches(pattern, word); });
  if (words.size() == 1) return words[0];
  throw InputError(fmt::format("\"{}\": expected a pattern of one command; it matches {}", printable(pattern),
                               words.empty() ? "none" : fmt::format("{}", fmt::join(words, ", "))));
}

}  // namespace

std::optional<std::string_view> osc_word(std::string_view address, std::string_view token) {
  const std::size_t slash = address.find('/', 1);
  const std::string_view root = address.substr(std::min<std::size_t>(address.size(), 1), slash - 1);
  const bool ours = root == kRoot || (is_osc_pattern(root) && osc_matches(root, kRoot));
  if (slash == address.npos || !address.starts_with('/') || !ours) {
    throw InputError(fmt::format("\"{}\": expected an address like /cupola/go", printable(address)));
  }
  std::string_view rest = address.substr(slash + 1);
  if (!token.empty()) {
    const bool right = same_text(rest.substr(0, token.size()), token) &&
                       rest.substr(std::min(rest.size(), token.size())).starts_with('/');
    if (!right) return std::nullopt;
    rest.remove_prefix(token.size() + 1);
  }
  // Where there is a slash it is no command, and no sign of a pattern reaches across it.
  return is_osc_pattern(rest) && rest.find('/') == rest.npos ? word_of_pattern(rest) : rest;
}

std::optional<PlayerCommand> parse_osc_command(std::string_view word, std::span<const OscValue> values,
                                               std::span<const std::string> cues) {
  const std::string said = printable(word);
  const CommandArgument takes = argument_of(said);
  const bool button = takes == CommandArgument::kNone || takes == CommandArgument::kSwitch;
  if (button && values.size() == 1) {
    if (std::holds_alternative<OscImpulse>(values[0])) return parse_command(said, "", cues);
    if (const std::optional<bool> down = pressed(values[0])) {
      if (takes == CommandArgument::kSwitch) return parse_command(said, *down ? "on" : "off", cues);
      return *down ? std::optional(parse_command(said, "", cues)) : std::nullopt;
    }
  }
  std::string argument;
  for (const OscValue& value : values) {
    if (!argument.empty()) argument += ' ';
    argument += text_of(said, value, takes == CommandArgument::kWhole);
  }
  return parse_command(said, argument, cues);
}

}  // namespace cupola
