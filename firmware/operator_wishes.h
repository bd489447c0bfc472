// What the operator wants of the coming frame: all commands since the one before, put together.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <span>

#include "firmware/command_queue.h"
#include "firmware/frame_mix.h"
#include "firmware/player_command.h"

namespace cupola {

// One thread, the queue's only taker. Does not allocate.
class OperatorWishes {
 public:
  // Takes the queue's commands, for the frame that is to be seen at `flip`.
  void obey(CommandQueue& queue, std::chrono::nanoseconds flip) noexcept;

  bool held() const noexcept { return held_; }                    // the show's time stands still
  bool black() const noexcept { return black_ || light() == 0; }  // the frame is to be black
  // How much of the frame is seen, from 0 to kWholeWeight; the rest is black.
  std::int32_t light() const noexcept { return light_; }
  int volume() const noexcept { return volume_; }  // of the sound, percent
  // The test pattern that is to lie over the show, as PlayerCommand has it.
  std::size_t pattern() const noexcept { return pattern_; }
  // Whether a screenshot was asked for since the last obey().
  bool screenshot() const noexcept { return screenshot_; }
  // Whether a reload was asked for since then.
  bool reload() const noexcept { return reload_; }
  // Taken by the last obey(), in their order: those that are for the show itself.
  std::span<const PlayerCommand> for_show() const noexcept { return {for_show_.data(), count_}; }

 private:
  bool held_ = false;
  void light_up() noexcept {
    black_ = false;
    in_ = true;
    light_ = kWholeWeight;
  }
  void fade(bool in, std::chrono::nanoseconds length) noexcept;
  bool dark() const noexcept { return black_ || !in_; }  // or getting there

  int volume_ = 100;
  bool black_ = false;
  std::size_t pattern_ = 0;
  bool screenshot_ = false;
  bool reload_ = false;
  bool in_ = true;  // where a fade goes to
  std::chrono::nanoseconds flip_{0};
  std::chrono::nanoseconds fade_length_{0};  // from dark to light
  std::chrono::nanoseconds fade_done_{0};    // of these, towards the light
  std::int32_t light_ = kWholeWeight;
  std::array<PlayerCommand, CommandQueue::kSlots> for_show_;
  std::size_t count_ = 0;
};

}  // namespace cupola
