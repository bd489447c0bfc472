// The words for commands.
// SPDX-License-Identifier: MIT
#include "firmware/player_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <vector>

#include "pipeline/frame/error.h"
#include "pipeline/settings/settings.h"

namespace cupola {
namespace {

constexpr double kLongestSeek = 1e7;     // seconds, as duration_s in a show
constexpr double kLongestFade = 3600.0;  // seconds
constexpr double kUsualFade = 2.0;
constexpr int kKeyVolume = 5;  // percent that + and - change

struct Word {
  std::string_view word;
  PlayerAction action;
  CommandArgument argument;
};
constexpr std::array<Word, 14> kWords = {
    {{"play", PlayerAction::kPlay, CommandArgument::kNone},
     {"pause", PlayerAction::kPause, CommandArgument::kNone},
     {"play-pause", PlayerAction::kPlayPause, CommandArgument::kNone},
     {"go", PlayerAction::kGo, CommandArgument::kNone},
     {"next", PlayerAction::kNext, CommandArgument::kNone},
     {"previous", PlayerAction::kPrevious, CommandArgument::kNone},
     {"seek", PlayerAction::kSeek, CommandArgument::kText},
     {"cue", PlayerAction::kCue, CommandArgument::kText},
     {"blackout", PlayerAction::kBlackoutToggle, CommandArgument::kSwitch},
     {"fade", PlayerAction::kFade, CommandArgument::kText},
     {"volume", PlayerAction::kVolume, CommandArgument::kWhole},
     {"test-pattern", PlayerAction::kTestPatternNext, CommandArgument::kText},
     {"screenshot", PlayerAction::kScreenshot, CommandArgument::kNone},
     {"reload", PlayerAction::kReload, CommandArgument::kNone}}};
constexpr auto kWordsAlone = [] {
  std::array<std::string_view, kWords.size()> words;
  for (std::size_t i = 0; i < words.size(); ++i) words[i] = kWords[i].word;
  return words;
}();
constexpr std::array<std::string_view, 10> kPatterns = {
    "grid",    "alignment",    "focus",           "bars",      "white", "grey",
    "checker", "fine-checker", "rotated-checker", "zone-plate"};

// All of `text`, or none.
template <class Number>
std::optional<Number> number_of(std::string_view text) {
  Number number{};
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (text.empty() || error != std::errc() || end != text.data() + text.size()) return std::nullopt;
  return number;
}

const Word& known_word(std::string_view word) {
  for (const Word& known : kWords) {
    if (known.word == word) return known;
  }
  const std::string_view nearest = nearest_name(word, kWordsAlone);
  throw InputError(fmt::format("\"{}\": no such command; expected one of {}{}", word,
                               fmt::join(kWordsAlone, ", "),
                               nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
}

std::chrono::nanoseconds parse_position(std::string_view argument) {
  const std::optional<double> seconds = number_of<double>(argument);
  if (!seconds || !(*seconds >= 0.0 && *seconds <= kLongestSeek)) {
    throw InputError(
        fmt::format("seek: expected seconds from 0 to {:.0f}, not \"{}\"", kLongestSeek, argument));
  }
  return std::chrono::nanoseconds(std::llround(*seconds * 1e9));
}

std::size_t parse_cue(std::string_view argument, std::span<const std::string> cues) {
  for (std::size_t i = 0; i < cues.size(); ++i) {
    if (cues[i] == argument) return i;
  }
  const std::optional<std::size_t> number = number_of<std::size_t>(argument);
  if (number && *number >= 1 && *number <= cues.size()) return *number - 1;
  const std::vector<std::string_view> names(cues.begin(), cues.end());
  const std::string_view nearest = nearest_name(argument, names);
  throw InputError(fmt::format("cue: expected a cue's name or a number from 1 to {}, not \"{}\"{}",
                               cues.size(), argument,
                               nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
}

PlayerAction parse_blackout(std::string_view argument) {
  if (argument.empty() || argument == "toggle") return PlayerAction::kBlackoutToggle;
  if (argument == "on") return PlayerAction::kBlackout;
  if (argument == "off") return PlayerAction::kBlackoutOff;
  throw InputError(fmt::format("blackout: expected on, off or toggle, not \"{}\"", argument));
}

// A pattern's name, "off" or nothing.
void parse_pattern(std::string_view argument, PlayerCommand& command) {
  if (argument.empty()) return;
  command.action = PlayerAction::kTestPattern;
  if (argument == "off") return;
  const auto found = std::find(kPatterns.begin(), kPatterns.end(), argument);
  if (found == kPatterns.end()) {
    const std::string_view nearest = nearest_name(argument, kPatterns);
    throw InputError(fmt::format("test-pattern: expected off or one of {}, not \"{}\"{}",
                                 fmt::join(kPatterns, ", "), argument,
                                 nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
  }
  command.cue = static_cast<std::size_t>(found - kPatterns.begin()) + 1;
}

// "out 2.5", "in", "3" or nothing.
void parse_fade(std::string_view argument, PlayerCommand& command) {
  std::string_view rest = argument;
  for (const auto& [word, action] : {std::pair<std::string_view, PlayerAction>("out", PlayerAction::kFadeOut),
                                     {"in", PlayerAction::kFadeIn}}) {
    if (rest != word && !rest.starts_with(std::string(word) + ' ')) continue;
    command.action = action;
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
    break;
  }
  const std::optional<double> seconds = rest.empty() ? kUsualFade : number_of<double>(rest);
  if (!seconds || !(*seconds >= 0.0 && *seconds <= kLongestFade)) {
    throw InputError(
        fmt::format("fade: expected seconds from 0 to {:.0f}, with out or in before them or not, "
                    "like \"out 2.5\"; not \"{}\"",
                    kLongestFade, argument));
  }
  command.position = std::chrono::nanoseconds(std::llround(*seconds * 1e9));
}

// "80", "+5" or "-5".
void parse_volume(std::string_view argument, PlayerCommand& command) {
  std::string_view digits = argument;
  const bool more = digits.starts_with('+');
  const bool by = more || digits.starts_with('-');
  if (more) digits.remove_prefix(1);
  const std::optional<int> percent = digits.starts_with('+') ? std::nullopt : number_of<int>(digits);
  if (!percent || (more && *percent < 0) || *percent < (by ? -100 : 0) || *percent > 100) {
    throw InputError(fmt::format(
        "volume: expected percent from 0 to 100, or +5 or -5 for so much more or less, not \"{}\"",
        argument));
  }
  if (by) command.action = PlayerAction::kVolumeBy;
  command.volume = *percent;
}

}  // namespace

std::span<const std::string_view> test_patterns() {
  return kPatterns;
}

std::span<const std::string_view> command_words() {
  return kWordsAlone;
}

CommandArgument argument_of(std::string_view word) {
  return known_word(word).argument;
}

PlayerCommand parse_command(std::string_view word, std::string_view argument,
                            std::span<const std::string> cues) {
  PlayerCommand command{known_word(word).action};
  if (command.action == PlayerAction::kSeek) {
    command.position = parse_position(argument);
  } else if (command.action == PlayerAction::kCue) {
    command.cue = parse_cue(argument, cues);
  } else if (command.action == PlayerAction::kBlackoutToggle) {
    command.action = parse_blackout(argument);
  } else if (command.action == PlayerAction::kFade) {
    parse_fade(argument, command);
  } else if (command.action == PlayerAction::kVolume) {
    parse_volume(argument, command);
  } else if (command.action == PlayerAction::kTestPatternNext) {
    parse_pattern(argument, command);
  } else if (!argument.empty()) {
    throw InputError(fmt::format("{}: expected nothing after it, not \"{}\"", word, argument));
  }
  return command;
}

std::optional<PlayerCommand> command_of_key(char key) {
  switch (key) {
    case ' ':
      return PlayerCommand{PlayerAction::kPlayPause};
    case 'g':
      return PlayerCommand{PlayerAction::kGo};
    case 'n':
    case '>':
      return PlayerCommand{PlayerAction::kNext};
    case 'p':
    case '<':
      return PlayerCommand{PlayerAction::kPrevious};
    case 'f':
      return PlayerCommand{PlayerAction::kFade, std::chrono::nanoseconds(std::llround(kUsualFade * 1e9))};
    case 'b':
      return PlayerCommand{PlayerAction::kBlackoutToggle};
    case '+':
    case '-': {
      PlayerCommand command{PlayerAction::kVolumeBy};
      command.volume = key == '+' ? kKeyVolume : -kKeyVolume;
      return command;
    }
    case 't':
      return PlayerCommand{PlayerAction::kTestPatternNext};
    case 'r':
      return PlayerCommand{PlayerAction::kReload};
    case 's':
      return PlayerCommand{PlayerAction::kScreenshot};
    default:
      return std::nullopt;
  }
}

std::string describe(const PlayerCommand& command, std::span<const std::string> cues) {
  switch (command.action) {
    case PlayerAction::kSeek:
      return fmt::format("seek {}", static_cast<double>(command.position.count()) / 1e9);
    case PlayerAction::kCue:
      return fmt::format("cue {}", command.cue < cues.size() ? cues[command.cue] : "?");
    case PlayerAction::kVolume:
      return fmt::format("volume {}", command.volume);
    case PlayerAction::kVolumeBy:
      return fmt::format("volume {:+}", command.volume);
    case PlayerAction::kTestPattern:
      return fmt::format("test-pattern {}",
                         command.cue == 0 ? "off" : kPatterns[std::min(command.cue, kPatterns.size()) - 1]);
    case PlayerAction::kBlackout:
      return "blackout on";
    case PlayerAction::kBlackoutOff:
      return "blackout off";
    case PlayerAction::kFade:
    case PlayerAction::kFadeOut:
    case PlayerAction::kFadeIn:
      return fmt::format("fade {}{}",
                         command.action == PlayerAction::kFade      ? ""
                         : command.action == PlayerAction::kFadeOut ? "out "
                                                                    : "in ",
                         static_cast<double>(command.position.count()) / 1e9);
    default:
      break;
  }
  for (const Word& known : kWords) {
    if (known.action == command.action) return std::string(known.word);
  }
  return {};
}

}  // namespace cupola
