// Test patterns that are laid over a running show: drawn off the frame loop, whole, before it sees them.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <atomic>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <mutex>

#include "firmware/event_log.h"
#include "firmware/handover.h"
#include "firmware/side_work.h"
#include "pipeline/frame/image.h"

namespace cupola {

class PatternBoard {
 public:
  // Draws pattern `pattern`, counted from 1, into all of `into` (kXrgb8888); may throw.
  using Draw = std::function<void(std::size_t pattern, const MutableImage& into)>;
  // Memory for two frames is taken when a pattern is first wanted. `log` is borrowed for the board's life.
  PatternBoard(Size frame, Draw draw, EventLog& log);

  // Draws with that from now on, also what lies there; the old pattern lies until then. Not the loop's: it
  // may wait a moment for who calls it too, or for the side.
  void draw_by(Draw draw);

  // The loop's, once a frame; neither waits nor allocates. `wanted`: 0 for none. Null until it is drawn;
  // where another one is laid already, that one until then. What is given stands until the next call.
  const ImageBuffer* picture(std::size_t wanted) noexcept;
  std::size_t laid() const noexcept { return laid_; }  // what the last call gave

 private:
  struct Picture {
    std::size_t pattern = 0;
    int by = 0;  // as drawers_
    ImageBuffer image;
    bool lent = false;  // offered to the loop, or with it
  };
  void work();

  Size frame_;
  EventLog& log_;
  std::mutex mutex_;
  Draw next_draw_;               // null once the side has it
  std::atomic<int> drawers_{0};  // that replaced another one
  std::atomic<std::size_t> wanted_{0};
  Handover<Picture> handover_;
  // The loop's:
  Picture* held_ = nullptr;
  std::size_t asked_ = 0;
  std::size_t laid_ = 0;
  // The side's:
  std::array<Picture, 2> pictures_;
  Draw draw_;
  int by_ = 0;             // as drawers_ when it came
  std::size_t drawn_ = 0;  // last, or tried, by draw_
  SideWork side_;          // last: it uses the others
};

struct Show;
class TableCache;
enum class Cpu : std::uint8_t;

// A board for the show's rig: each pattern as a test-pattern cue shows it, through the rig's warp. The faces
// are half as wide as the frame, to the next power of two. The table is built with one thread, or comes from
// `cache`.
PatternBoard::Draw pattern_drawer(const Show& show, Cpu cpu, const TableCache& cache);
// The side of its faces.
int pattern_face_side(Size frame);

}  // namespace cupola
