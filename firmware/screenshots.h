// The frame as it is presented, into a file: taken by the frame loop, written beside it.
// SPDX-License-Identifier: MIT
#pragma once

#include <atomic>
#include <chrono>
#include <cstdint>
#include <filesystem>
#include <functional>
#include <string>

#include "firmware/event_log.h"
#include "firmware/frame_mix.h"
#include "firmware/handover.h"
#include "firmware/side_work.h"
#include "pipeline/frame/image.h"

namespace cupola {

struct Screenshot {
  ImageBuffer frame;                  // kXrgb8888
  std::int32_t light = kWholeWeight;  // `frame` is to be dimmed to it
  std::size_t cue = 0;                // from 0
  std::chrono::nanoseconds position{0};
};

class Screenshots {
 public:
  // Called with the frame as it was presented, off the loop; may throw. Returns what was written.
  using Keep = std::function<std::string(const Screenshot&)>;
  // Memory for two frames is taken with the first one. `log` is borrowed for their life.
  Screenshots(Size frame, Keep keep, EventLog& log);

  // The loop's; none waits or allocates. Asks for one: there is memory for it at one of the next frames, or
  // not until the one before is written. Asking again meanwhile asks for the same.
  void ask() noexcept;
  // The memory for it, to be filled and given back; null while there is none or nobody asks.
  Screenshot* due() noexcept { return handover_.take(); }
  void give_back(Screenshot* taken) noexcept;

 private:
  void work();
  void write() noexcept;

  Size frame_;
  Keep keep_;
  EventLog& log_;
  std::atomic<bool> asked_{false};
  Handover<Screenshot> handover_;
  // The side's:
  Screenshot screenshot_;
  ImageBuffer dimmed_;
  bool lent_ = false;
  SideWork side_;  // last: it uses the others
};

// Writes PNGs into `folder`, which is made: NAME-cue-2-12.500s-20261122T224501Z.png. None is written over.
Screenshots::Keep screenshot_writer(std::filesystem::path folder, std::string name);

}  // namespace cupola
