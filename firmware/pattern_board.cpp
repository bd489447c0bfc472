// Two pictures change places: one lies on the dome while the other is drawn.
// SPDX-License-Identifier: MIT
#include "firmware/pattern_board.h"

#include <fmt/format.h>

#include <algorithm>
#include <bit>
#include <exception>
#include <utility>

#include "firmware/player_command.h"
#include "firmware/show.h"
#include "firmware/show_frames.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

PatternBoard::PatternBoard(Size frame, Draw draw, EventLog& log)
    : frame_(frame), log_(log), draw_(std::move(draw)), side_([this] { work(); }) {}

void PatternBoard::draw_by(Draw draw) {
  {
    const std::lock_guard lock(mutex_);
    next_draw_ = std::move(draw);
    drawers_.fetch_add(1);
  }
  side_.ring();
}

const ImageBuffer* PatternBoard::picture(std::size_t wanted) noexcept {
  if (wanted != asked_) {
    asked_ = wanted;
    wanted_.store(wanted);
    side_.ring();
  }
  if (Picture* drawn = handover_.take()) {
    if (held_) {
      handover_.give_back(held_);
      side_.ring();
    }
    held_ = drawn;
  }
  const bool is_it = held_ && held_->pattern == wanted && held_->by == drawers_.load();
  const bool shows = wanted != 0 && held_ && (is_it || laid_ != 0);
  laid_ = shows ? held_->pattern : 0;
  return shows ? &held_->image : nullptr;
}

void PatternBoard::work() {
  if (Picture* back = handover_.returned()) back->lent = false;
  {
    const std::lock_guard lock(mutex_);
    if (next_draw_) {
      draw_ = std::exchange(next_draw_, nullptr);
      by_ = drawers_.load();
      drawn_ = 0;
    }
  }
  const std::size_t wanted = wanted_.load();
  if (wanted == 0 || wanted == drawn_) return;
  Picture* free = nullptr;
  for (Picture& picture : pictures_) {
    if (!picture.lent) free = &picture;
  }
  if (!free) {  // one is with the loop and one was not taken yet
    free = handover_.offer(nullptr);
    if (!free) return;  // taken meanwhile: what it gives back rings again
    free->lent = false;
  }
  drawn_ = wanted;
  try {
    if (free->image.empty()) free->image = ImageBuffer(PixelFormat::kXrgb8888, frame_);
    draw_(wanted, free->image.pixels());
  } catch (const std::exception& error) {
    log_.warn(Topic::kControl, fmt::format("test-pattern {}: {}", test_patterns()[wanted - 1], error.what()));
    drawn_ = 0;
    return;
  }
  free->pattern = wanted;
  free->by = by_;
  free->lent = true;
  if (Picture* untaken = handover_.offer(free)) untaken->lent = false;
}

int pattern_face_side(Size frame) {
  const unsigned half = static_cast<unsigned>(std::max(frame.width, frame.height) + 1) / 2;
  return static_cast<int>(std::clamp(std::bit_ceil(half), 16U, 4096U));
}

PatternBoard::Draw pattern_drawer(const Show& show, Cpu cpu, const TableCache& cache) {
  Show board;
  board.name = show.name;
  board.rig = show.rig;
  board.rig.budget_ms.reset();  // there is no quiet machine to measure on
  board.cues.resize(1);
  board.cues[0].source = CueSource::kTestPattern;
  const int side = pattern_face_side(show.rig.frame.size);
  board.cues[0].face_size = {side, side};
  return [board, cpu, cache = cache](std::size_t pattern, const MutableImage& into) mutable {
    board.cues[0].world = board.cues[0].name = test_patterns()[pattern - 1];
    WorkerPool pool(1);
    ShowFrames frames(board, Method::kEwa, cpu, pool, false, &cache);
    frames.advance({});
    frames.warp(into, 0);
  };
}

}  // namespace cupola
