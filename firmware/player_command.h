// What the operator can ask of the player: one set for buttons, keys, HTTP and OSC, and its names.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

namespace cupola {

enum class PlayerAction : std::uint8_t {
  kPlay,
  kPause,
  kPlayPause,  // whichever it is not
  kGo,         // on where a cue waits; ends a pause too
  kNext,       // the cue that follows, at once
  kPrevious,   // the cue before in the list, at once
  kSeek,
  kCue,
  kBlackout,  // dark until kBlackoutOff
  kBlackoutOff,
  kBlackoutToggle,
  kFadeOut,  // to black, within `position`; dark until something lights it again
  kFadeIn,   // back
  kFade,     // whichever of the two it is not
  kVolume,   // of the sound
  kVolumeBy,
  kTestPattern,      // laid over the show, whose time goes on
  kTestPatternNext,  // the one after that which is laid; none after the last
  kScreenshot,
  kReload,  // the show's file is read again
};

struct PlayerCommand {
  PlayerAction action = PlayerAction::kPlay;
  std::chrono::nanoseconds position{0};  // kSeek: from the cue's start; fades: how long from dark to light
  // kCue: its place in the show, from 0. kTestPattern: its place in test_patterns(), from 1; 0 for none.
  std::size_t cue = 0;
  int volume = 0;  // kVolume: percent; kVolumeBy: so much more, or less
  friend bool operator==(const PlayerCommand&, const PlayerCommand&) = default;
};

// The names of the patterns that can be laid over a show.
std::span<const std::string_view> test_patterns();

// Of a show of these `cues`. `argument` is empty where the command takes none. "seek" takes seconds, 0 to
// 1e7; "cue" a cue's name or its number from 1, a name first; "blackout" on, off or toggle, or nothing for
// toggle; "fade" seconds, 0 to 3600, 2 where there are none, and out or in before them, or neither for
// whichever it is not; "volume" percent, 0 to 100, or with a sign so much more or less; "test-pattern" a
// name, off, or nothing for the next one. Throws InputError that names the command and what was expected.
PlayerCommand parse_command(std::string_view word, std::string_view argument,
                            std::span<const std::string> cues);

// All words that parse_command() takes.
std::span<const std::string_view> command_words();

// What a command's argument is, for those who send numbers and switches in place of text.
enum class CommandArgument : std::uint8_t { kNone, kSwitch, kWhole, kText };
// Throws InputError for a word that is no command.
CommandArgument argument_of(std::string_view word);

// The command of a key: a space, a small letter, + and -, or < and > for the arrows; none where it has none.
std::optional<PlayerCommand> command_of_key(char key);

// As parse_command() takes it, for the log: "seek 12.5".
std::string describe(const PlayerCommand& command, std::span<const std::string> cues);

}  // namespace cupola
