// The frame that a context draws in: the same for every kind of context.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>

#include "hal/gl/offscreen_gl.h"

namespace cupola {

// Lives and dies with its context, which is current whenever this is called.
class GlFrame {
 public:
  // Loads the functions, makes the frame and completes the description. Throws std::runtime_error.
  void open(GlLoader loader, GlDescription& description);
  void bind() const noexcept;
  bool read_back(std::byte* rows, std::ptrdiff_t stride) const noexcept;
  const GlFunctions& gl() const { return gl_; }

 private:
  GlFunctions gl_{};
  int width_ = 0;
  int height_ = 0;
  GLuint framebuffer_ = 0;
};

}  // namespace cupola
