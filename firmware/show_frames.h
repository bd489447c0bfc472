// A show made ready: every cue opened and its warp built, so that frames can be made without allocating.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "firmware/change_history.h"
#include "firmware/frame_maker.h"
#include "firmware/live_frames.h"
#include "firmware/show.h"
#include "firmware/timeline.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

// What of a cue's source is played when; throws InputError where the source has no such part.
CueTiming timing_of(const Cue& cue, const FaceSource& source);

// How pictures in files become faces.
enum class Decoding : std::uint8_t {
  kInTurn,       // when they are asked for, by all threads
  kAhead,        // by a thread a cue, ahead of need; never waited for
  kAheadInStep,  // the same, but waited for: where no time passes meanwhile
};

class ShowFrames final : public FrameMaker {
 public:
  // Throws InputError. `pool` is borrowed for the show's life. With `whole_faces` sources make every texel,
  // not only those the warp reads. Tables come from `cache`, where there is one. `live` is what live cues
  // show; without it a show that has some is refused. Its cameras run as long as the show does.
  ShowFrames(const Show& show, Method method, Cpu cpu, WorkerPool& pool, bool whole_faces = false,
             TableCache* cache = nullptr, Decoding decoding = Decoding::kInTurn,
             std::unique_ptr<LiveFrames> live = nullptr);

  Size frame_size() const { return frame_size_; }
  double rate() const override { return rate_; }  // of the first cue
  PixelFormat format() const;                     // of the faces: 16 bits if any cue has 16
  const Timeline& timeline() const { return timeline_; }

  // Before the first advance(): as if cue `cue` had begun `played` before the show's time 0, and the show
  // gone on since. False where it would be over by now: then it begins at its start.
  bool begin_in(std::size_t cue, std::chrono::nanoseconds played);
  Change advance(const Due& due) noexcept override;
  WarpWork warp(const MutableImage& frame, int age) noexcept override;
  std::optional<YuvColour> nv12_colour() const noexcept override;
  bool gives_nv12() const noexcept override;
  WarpWork warp_nv12(const MutableNativeImage& frame, int age) noexcept override;
  FacePicture face(std::size_t view) const noexcept override;
  // Texels of the faces fetched so far that no pixel needs.
  std::int64_t texels_unneeded() const { return texels_unneeded_; }
  // Of all cues together.
  FileCounts file_counts() const noexcept;
  void shown(std::chrono::nanoseconds flipped_at) noexcept override;

  // Stands for all that bears on the pixels of the frames but the show's own cues.
  std::vector<std::uint64_t> key() const;
  const FaceSet& faces() const { return faces_; }
  const LiveFrames* live() const { return live_.get(); }  // null: no cue is live
  const Rig& rig() const { return cues_[moment_.cue].rig; }
  const std::string& cue_name() const { return cues_[moment_.cue].name; }
  void report(ShowReport& report) const noexcept override;
  // Why the last advance() failed.
  std::string trouble() const;

 private:
  // At most so many bytes, no zero after them; the end.
  char* format_trouble(char* into, std::size_t most) const;

  struct OpenCue {
    std::string name;
    Rig rig;                             // with the sizes of the source's faces
    std::unique_ptr<FaceSource> source;  // null: live
    FileFaces* files = nullptr;          // the source, where it reads files
    std::size_t warp = 0;
  };
  struct CueWarp {  // shared by cues with faces of the same sizes
    std::unique_ptr<FrameWarp> warp;
    ChangeHistory history;
    std::vector<EvenCells> even;       // of the faces fetched last
    std::int64_t texels_unneeded = 0;  // of one set of faces
  };
  Change advance_cues(const Moment& moment, std::optional<Fade> fade) noexcept;
  Change advance_live(const Due& due, Change change) noexcept;
  bool is_live(std::size_t cue) const { return !cues_[cue].source; }
  void open_ahead(OpenCue& cue, const CueTiming& timing, bool in_step) const;
  // New faces were fetched for `warp`; `changed` as in FaceSet.
  void note(CueWarp& warp, std::span<const ChangedCells> changed) noexcept;

  Size frame_size_;
  double rate_ = 60.0;
  std::unique_ptr<LiveFrames> live_;
  bool live_is_seen_ = false;
  std::vector<OpenCue> cues_;
  std::vector<CueWarp> warps_;
  Timeline timeline_;
  std::chrono::nanoseconds time_{0};  // of the last advance()
  Moment moment_{0, -1};
  bool asked_ = false;                      // moment_ was asked for ...
  bool failed_ = false;                     // ... in vain
  std::optional<std::size_t> shown_cue_;    // whose changes the history has; none after a fade
  std::size_t faces_cue_ = 0;               // whose faces_ are
  std::optional<std::size_t> warped_with_;  // which of warps_ made the last frame
  FaceSet faces_;
  std::int64_t texels_unneeded_ = 0;

  // What fades need: two frames, where a cue has one. Displays take XRGB; for other formats they are made
  // anew at the first frame.
  void take_fades(PixelFormat format);
  bool keep_mixed() noexcept;
  void rest_unseen(const Moment& moment, const std::optional<Fade>& fade) noexcept;
  Fetch fetch_new() noexcept;
  void fetch_old(const Fade& fade) noexcept;
  WarpWork warp_fade(const MutableImage& frame) noexcept;
  WorkerPool& pool_;
  std::optional<Fade> fade_;                  // of moment_
  FaceSet old_faces_;                         // of fade_->from
  bool old_stands_ = false;                   // old_frame_ is what a fade showed that this one cut short
  bool old_is_new_ = false;                   // not yet in old_frame_
  bool new_is_new_ = false;                   // faces_ are not yet in new_frame_
  std::optional<std::size_t> new_frame_cue_;  // whose picture new_frame_ is, or will be
  ImageBuffer old_frame_, new_frame_;         // of the one shown before and of the one coming
};

}  // namespace cupola
