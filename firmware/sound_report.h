// How the show's sound fares, as its thread says it.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>

namespace cupola {

// Plain memory: copied from thread to thread.
struct SoundReport {
  bool wanted = false;    // some cue has a sound
  bool master = false;    // the show's time follows it
  bool working = false;   // the device is there
  bool sounding = false;  // a cue's sound is played
  int rate = 0;           // frames a second
  int channels = 0;
  std::chrono::nanoseconds drift{0};  // the sound heard against the show's time; above 0: it is early
  double device_ppm = 0.0;            // by which the device's clock is faster than the machine's
  double applied_ppm = 0.0;  // by which the sound, or as master the show, is played faster to keep step
  std::int64_t underruns = 0;
  std::int64_t losses = 0;          // times that the device went away
  std::int64_t missing = 0;         // frames that were not decoded in time
  std::int64_t damaged = 0;         // packets of files that could not be decoded
  std::array<char, 200> trouble{};  // why the device is away; empty while it is there
};

}  // namespace cupola
