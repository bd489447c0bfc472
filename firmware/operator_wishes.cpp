// Pauses and blackouts are the loop's; the rest goes to the show.
// SPDX-License-Identifier: MIT
#include "firmware/operator_wishes.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace cupola {

using std::chrono::nanoseconds;

// From the light that there is: a fade that is turned round takes as long as it has come.
void OperatorWishes::fade(bool in, nanoseconds length) noexcept {
  if (black_) light_ = 0;
  black_ = false;
  in_ = in;
  fade_length_ = std::max(length, nanoseconds(1));
  fade_done_ = nanoseconds(std::llround(static_cast<double>(fade_length_.count()) * light_ / kWholeWeight));
}

void OperatorWishes::obey(CommandQueue& queue, nanoseconds flip) noexcept {
  const nanoseconds passed = flip - std::exchange(flip_, flip);
  if (light_ != (in_ ? kWholeWeight : 0)) {
    fade_done_ = std::clamp(fade_done_ + (in_ ? passed : -passed), nanoseconds(0), fade_length_);
    light_ = static_cast<std::int32_t>(std::lround(kWholeWeight * static_cast<double>(fade_done_.count()) /
                                                   static_cast<double>(fade_length_.count())));
  }
  count_ = 0;
  screenshot_ = reload_ = false;
  // Bounded, however fast others push.
  for (std::size_t i = 0; i < for_show_.size(); ++i) {
    const std::optional<PlayerCommand> command = queue.take();
    if (!command) return;
    switch (command->action) {
      case PlayerAction::kPlay:
        held_ = false;
        break;
      case PlayerAction::kPause:
        held_ = true;
        break;
      case PlayerAction::kPlayPause:
        held_ = !held_;
        break;
      case PlayerAction::kBlackout:
        black_ = true;
        break;
      case PlayerAction::kBlackoutOff:
        light_up();
        break;
      case PlayerAction::kBlackoutToggle:
        if (dark()) {
          light_up();
        } else {
          black_ = true;
        }
        break;
      case PlayerAction::kFadeOut:
      case PlayerAction::kFadeIn:
        fade(command->action == PlayerAction::kFadeIn, command->position);
        break;
      case PlayerAction::kFade:
        fade(dark(), command->position);
        break;
      case PlayerAction::kVolume:
        volume_ = std::clamp(command->volume, 0, 100);
        break;
      case PlayerAction::kVolumeBy:
        volume_ = std::clamp(volume_ + command->volume, 0, 100);
        break;
      case PlayerAction::kTestPattern:
        pattern_ = command->cue <= test_patterns().size() ? command->cue : 0;
        break;
      case PlayerAction::kTestPatternNext:
        pattern_ = (pattern_ + 1) % (test_patterns().size() + 1);
        break;
      case PlayerAction::kScreenshot:
        screenshot_ = true;
        break;
      case PlayerAction::kReload:
        reload_ = true;
        break;
      case PlayerAction::kGo:
        held_ = false;
        [[fallthrough]];
      case PlayerAction::kNext:
      case PlayerAction::kPrevious:
      case PlayerAction::kSeek:
      case PlayerAction::kCue:
        for_show_[count_++] = *command;
        break;
    }
  }
}

}  // namespace cupola
