// What the frame loop plays: something that knows the picture due at a flip, and draws it.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>

#include "firmware/face_picture.h"
#include "firmware/player_command.h"
#include "firmware/show_report.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/native_image.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

class FrameMaker {
 public:
  virtual ~FrameMaker() = default;

  enum class Change : std::uint8_t {
    kNew,        // the frame differs from the one before: warp it
    kUnchanged,  // it does not
    kFailed,     // the faces could not be had; the frame before stands
    kOver,       // the show is over
  };
  struct Due {
    std::chrono::nanoseconds time{0};              // of the show; must not run backwards
    std::chrono::nanoseconds flip{0};              // of the clock: when the frame will be seen
    std::span<const PlayerCommand> commands = {};  // the operator's, in order: from that time on
  };
  // Carries the commands out (those that it has no use for are passed over) and gets the faces due. May wait
  // for them, but only so long that warping still makes the flip.
  virtual Change advance(const Due& due) noexcept = 0;
  // Warps them into `frame`, which has the rig's size and any format. Where `frame` holds what warp() made
  // `age` calls ago, 1 being the last one, only what has changed since need be done; 0: it holds anything.
  virtual WarpWork warp(const MutableImage& frame, int age) noexcept = 0;
  // The colour of the frames that it can make in NV12, if any; always the same.
  virtual std::optional<YuvColour> nv12_colour() const noexcept { return std::nullopt; }
  // Whether the frame that is due is one of them: then this may be called in place of warp().
  virtual bool gives_nv12() const noexcept { return false; }
  virtual WarpWork warp_nv12(const MutableNativeImage& /*frame*/, int /*age*/) noexcept { return {}; }
  // What the last advance() left of a view, until the next one; none where there is no such view.
  virtual FacePicture face(std::size_t /*view*/) const noexcept { return {}; }
  // The frame warped last reached the screen, or was shown once more.
  virtual void shown(std::chrono::nanoseconds flipped_at) noexcept = 0;
  virtual double rate() const = 0;  // frames a second, where the display has no rate of its own
  // Where the show stands after the last advance(), and why that failed. Does not allocate.
  virtual void report(ShowReport& report) const noexcept = 0;
};

}  // namespace cupola
