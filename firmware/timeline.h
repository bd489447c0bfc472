// Which frame of which cue is due at a time of the show.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "firmware/player_command.h"

namespace cupola {

struct CueTiming {
  double rate = 60.0;                                 // frames a second, > 0
  std::int64_t first = 0;                             // the source's frame to begin with
  std::optional<std::int64_t> frames = std::nullopt;  // from there; none when the source never ends
  bool loop = false;                                  // begin again after the last; else it stands
  std::optional<std::chrono::nanoseconds> duration =
      std::nullopt;                                // none: until the last frame is over, or for ever
  std::optional<std::size_t> then = std::nullopt;  // the next cue; none: the show stops
  std::int64_t fade_frames = 0;  // the first so many are mixed with what was shown before; less than `frames`
  bool wait = false;             // at its end the last frame stands until go() or next_cue()
};

struct Moment {
  std::size_t cue = 0;
  std::int64_t frame = 0;  // of the cue's source
  friend bool operator==(const Moment&, const Moment&) = default;
};

// What is still seen of what was shown before the cue.
struct Fade {
  std::optional<Moment> from;  // none: black
  std::int32_t weight = 0;     // of the new cue, 0 to kWholeWeight
  friend bool operator==(const Fade&, const Fade&) = default;
};

// Times are nanoseconds of the show, which never run backwards from call to call: to go back is to let a cue
// begin at an earlier time, not to let time run back. A frame is due a quarter of its length early, 4 ms at
// most, so that flips that jitter about their times do not skip or repeat one.
class Timeline {
 public:
  explicit Timeline(std::vector<CueTiming> cues);  // at least one

  // None when the show is over. Does not allocate; nor does any of the following.
  std::optional<Moment> at(std::chrono::nanoseconds time) noexcept;

  // Of the moment that the last at() gave; none where nothing is mixed. The old cue goes on as long as it has
  // frames, then its last one stands; one that waited stands. The weight moves with the new cue's frames, so
  // it does not depend on when exactly the flips come. The first cue comes out of black. A seek ends a fade,
  // a cue that follows itself has none. Where a fade is cut short by another, `from` is the cue that was
  // coming; ShowFrames has what was seen of both.
  const std::optional<Fade>& fade() const { return fade_; }

  // The operator's, from `time` on; without effect when the show is over. What begins does so at its start.
  void next_cue(std::chrono::nanoseconds time) noexcept;      // what follows; after the last one nothing does
  void previous_cue(std::chrono::nanoseconds time) noexcept;  // the one before in the list; the first again
  // next_cue() where a cue waits or, having no end, would not come to it; else nothing.
  void go(std::chrono::nanoseconds time) noexcept;
  // Cue `cue`, which must be there.
  void jump(std::size_t cue, std::chrono::nanoseconds time) noexcept;
  // To `position` of the cue that plays, or to its end where it is shorter; before its start is its start.
  void seek(std::chrono::nanoseconds position, std::chrono::nanoseconds time) noexcept;

  // Before the first at(): as if cue `cue` had begun `played` before time 0 and the show gone on since.
  void begin_in(std::size_t cue, std::chrono::nanoseconds played) noexcept;

  std::size_t cues() const { return cues_.size(); }
  const CueTiming& timing(std::size_t cue) const { return cues_[cue]; }
  // Where the last at() stood.
  std::size_t cue() const { return cue_; }
  bool waiting() const { return waiting_; }  // a cue is at its end and waits
  // How long the cue has played at `time`; never longer than it is.
  std::chrono::nanoseconds position(std::chrono::nanoseconds time) const noexcept;
  // How long it is; none when it never ends.
  std::optional<std::chrono::nanoseconds> cue_length() const { return lengths_[cue_]; }

  // Where the show is `by` after `place` when nobody commands anything; none: it waits there, or is over.
  // Depends on the cues alone.
  struct Place {
    std::size_t cue = 0;
    std::chrono::nanoseconds position{0};
  };
  std::optional<Place> ahead(Place place, std::chrono::nanoseconds by) const noexcept;

  // How long the show is; none when it never ends by itself.
  std::optional<std::chrono::nanoseconds> length() const;

 private:
  std::optional<std::chrono::nanoseconds> length_of(const CueTiming& cue) const;

  // Frames of the cue that have begun at `within` from its start, less one; not yet those of a loop or a
  // part.
  static std::int64_t steps(const CueTiming& cue, std::chrono::nanoseconds within);
  Moment moment(std::size_t cue, std::int64_t step) const;
  std::optional<Fade> fade_at(std::int64_t step, std::chrono::nanoseconds time) const;

  struct From {
    std::size_t cue = 0;
    std::chrono::nanoseconds begin{0};
    bool waited = false;
  };

  std::vector<CueTiming> cues_;
  std::vector<std::optional<std::chrono::nanoseconds>> lengths_;
  std::size_t cue_ = 0;
  std::chrono::nanoseconds begin_{0};  // of the cue
  std::optional<From> from_;           // what was shown before it ...
  bool fades_ = true;                  // ... matters
  std::optional<Fade> fade_;
  bool waiting_ = false;
  bool over_ = false;
};

// Carries out what a command asks of the timeline from `time` on; commands for others are passed over, and so
// is a cue that is not there.
void obey(Timeline& timeline, const PlayerCommand& command, std::chrono::nanoseconds time) noexcept;

}  // namespace cupola
