// The youngest free buffer is drawn next: the less has changed since, the less has to be drawn.
// SPDX-License-Identifier: MIT
#include "hal/display/scanout_turns.h"

#include <cstddef>
#include <limits>

namespace cupola {

int ScanoutTurns::age() const {
  const std::int64_t held = presented_[static_cast<std::size_t>(back_)];
  const std::int64_t age = presents_ + 1 - held;
  return held == 0 || age > std::numeric_limits<int>::max() ? 0 : static_cast<int>(age);
}

void ScanoutTurns::presented() {
  presented_[static_cast<std::size_t>(back_)] = ++presents_;
  last_ = back_;
  choose_back();
}

void ScanoutTurns::flipped() {
  screen_ = in_flight_;
  in_flight_ = -1;
  choose_back();
}

void ScanoutTurns::switched_off() {
  screen_ = in_flight_ = -1;
  choose_back();
}

void ScanoutTurns::forget() {
  presented_ = {};
  presents_ = 0;
  last_ = -1;
  choose_back();
}

void ScanoutTurns::replaced() {
  const bool any = last_ >= 0;
  presented_ = {};
  screen_ = in_flight_ = -1;
  last_ = any ? 0 : -1;
  if (any) presented_[0] = presents_;
  choose_back();
}

void ScanoutTurns::choose_back() {
  // With one on the screen, another stuck on its way and the last not sent, the last is drawn over.
  int best = last_;
  std::int64_t youngest = -1;
  for (int i = 0; i < kBuffers; ++i) {
    if (i == screen_ || i == in_flight_ || i == last_) continue;
    const std::int64_t held = presented_[static_cast<std::size_t>(i)];
    if (held > youngest) {
      best = i;
      youngest = held;
    }
  }
  back_ = best;
}

}  // namespace cupola
