// OSC messages as commands: addresses are "/cupola/" and the command's word.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <variant>
#include <vector>

#include "firmware/osc_time.h"
#include "firmware/player_command.h"

namespace cupola {

struct OscImpulse {  // "I": no value but that it came
  friend bool operator==(OscImpulse, OscImpulse) = default;
};
using OscValue = std::variant<std::int64_t, double, bool, OscImpulse, std::string>;

struct OscMessage {
  std::string address;
  std::vector<OscValue> values;
  OscTime time = kOscAtOnce;  // its bundle's
};

// Of the address that asks how the player is; no command.
constexpr std::string_view kOscStatus = "status";

// The command of "/cupola/COMMAND", or of "/cupola/TOKEN/COMMAND" where there is a `token`; none where the
// token is not that. Either but the token may be a pattern, that of the command one that matches it and no
// other. Throws InputError for any other address. The word is the address's own, or for ever.
std::optional<std::string_view> osc_word(std::string_view address, std::string_view token);

// Numbers and texts are the command's argument, one after the other. A command without one is a button:
// nothing, an impulse, true and any number but 0 press it; false and 0 let it go, which is none. "blackout"
// is a switch, on and off, which an impulse or nothing turns over. "volume" takes fractions, rounded. Throws
// InputError.
std::optional<PlayerCommand> parse_osc_command(std::string_view word, std::span<const OscValue> values,
                                               std::span<const std::string> cues);

}  // namespace cupola
