// Where a show stands, as a file keeps it for a player that has to begin again.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>

#include "firmware/player_status.h"

namespace cupola {

// An instant that can be found again after the program, or the machine, has begun anew.
struct Instant {
  std::string boot;                    // which start of the machine; empty where that is not known
  std::chrono::nanoseconds booted{0};  // since then, sleep included
  std::chrono::nanoseconds wall{0};    // since 1970: jumps, and is what is left after a start of the machine
};
Instant instant_now();
// Never less than 0. By the time since the boot where both are of one, else by the wall's clock.
std::chrono::nanoseconds between(const Instant& earlier, const Instant& later);

struct ShowPosition {
  std::string show;  // its name
  std::size_t cue = 0;
  std::string cue_name;
  std::chrono::nanoseconds position{0};  // in the cue, at ...
  Instant at;
  bool held = false;                         // the show's time stood still
  bool dark = false;                         // by the operator's wish
  std::optional<int> volume = std::nullopt;  // percent; none in files from before there was sound
};

std::string position_text(const ShowPosition& position);
// Throws InputError for what position_text() does not write.
ShowPosition parse_position(std::string_view text);

// Where to go on: the cue of that name, and how long it will have played at `now`. None where the show has no
// such cue.
struct Resumption {
  std::size_t cue = 0;
  std::chrono::nanoseconds played{0};  // may be longer than the cue is
};
std::optional<Resumption> resume_at(const ShowPosition& position, std::span<const std::string> cues,
                                    const Instant& now);

}  // namespace cupola
