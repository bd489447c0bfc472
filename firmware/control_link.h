// What the frame loop and those who control it share.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <cstdint>

#include "firmware/command_queue.h"
#include "firmware/event_log.h"
#include "firmware/face_previews.h"
#include "firmware/frame_trace.h"
#include "firmware/pattern_board.h"
#include "firmware/player_status.h"
#include "firmware/preview.h"
#include "firmware/screenshots.h"
#include "firmware/show_reload.h"
#include "firmware/snapshot.h"

namespace cupola {

// The loop waits at none of them.
struct ControlLink {
  CommandQueue commands;          // to the loop
  Snapshot<PlayerStatus> status;  // from it
  Snapshot<SoundReport> sound;    // from the sound's thread
  Snapshot<OscReport> osc;        // from OSC's
  // By which the show's time is to pass faster than the clock's, in parts per billion: the sound's wish,
  // where it is the master.
  std::atomic<std::int64_t> pace_ppb{0};
  EventLog log;                        // from everybody
  FrameTrace trace;                    // from the loop
  Preview* preview = nullptr;          // borrowed; null where nobody can look
  FacePreviews* faces = nullptr;       // the same
  PatternBoard* patterns = nullptr;    // borrowed; null: none is laid
  ShowReload* reload = nullptr;        // borrowed; null: the show is not read again
  Screenshots* screenshots = nullptr;  // borrowed; null: none is taken
};

inline PlayerStatus read_status(const ControlLink& link) {
  PlayerStatus status = link.status.read();
  status.sound = link.sound.read();
  status.osc = link.osc.read();
  return status;
}

}  // namespace cupola
