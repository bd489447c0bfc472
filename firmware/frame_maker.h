// What the frame loop plays: something that knows the picture due at a flip, and draws it.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <string>

#include "pipeline/frame/image.h"
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
  // Gets the faces due at `time` of the show, which must not run backwards; they will be seen at the clock's
  // `flip`. May wait for them, but only so long that warping still makes the flip.
  virtual Change advance(std::chrono::nanoseconds time, std::chrono::nanoseconds flip) noexcept = 0;
  // Warps them into `frame`, which has the rig's size and any format. Where `frame` holds what warp() made
  // `age` calls ago, 1 being the last one, only what has changed since need be done; 0: it holds anything.
  virtual WarpWork warp(const MutableImage& frame, int age) noexcept = 0;
  // The frame warped last reached the screen, or was shown once more.
  virtual void shown(std::chrono::nanoseconds flipped_at) noexcept = 0;
  virtual double rate() const = 0;  // frames a second, where the display has no rate of its own
  // Why the last advance() failed.
  virtual std::string trouble() const = 0;
};

}  // namespace cupola
