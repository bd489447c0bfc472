// The player as others see it: what the frame loop publishes once a frame.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>

#include "firmware/loop_counts.h"
#include "firmware/show_report.h"
#include "firmware/sound_report.h"

namespace cupola {

enum class PlayerState : std::uint8_t { kStarting, kPlaying, kPaused, kWaiting, kOver };

constexpr const char* name_of(PlayerState state) {
  constexpr const char* kNames[] = {"starting", "playing", "paused", "waiting", "over"};
  return kNames[static_cast<std::size_t>(state)];
}

// Messages that came over OSC.
struct OscReport {
  bool wanted = false;        // somebody listens
  std::int64_t taken = 0;     // commands, and questions for the status
  std::int64_t released = 0;  // buttons let go: nothing to do
  std::int64_t refused = 0;   // ill-formed packets, unknown addresses, wrong values
  std::int64_t denied = 0;    // without the token
  std::int64_t crowded = 0;   // more at once than the player takes
};

// Plain memory: copied from thread to thread.
struct PlayerStatus {
  PlayerState state = PlayerState::kStarting;
  bool black = false;         // by the operator's wish
  double light = 1.0;         // the operator's fades: how much of the picture is seen
  std::size_t pattern = 0;    // the test pattern laid over it, from 1; 0: none
  bool display_away = false;  // for now
  bool failing = false;       // the last faces could not be had
  int show_number = 0;        // 0: the show of the start; each one that was read again has the next
  ShowReport show;
  LoopCounts counts;
  std::chrono::nanoseconds running{0};   // since the first flip
  std::chrono::nanoseconds shown_at{0};  // of the clock: the last flip
  std::chrono::nanoseconds period{0};    // from flip to flip
  std::chrono::nanoseconds due{0};       // of the clock: when the show stood at show.position
  int volume = 100;                      // percent, as the operator wants it
  SoundReport sound;                     // not the loop's: read_status() puts it in
  OscReport osc;                         // nor this
};

}  // namespace cupola
