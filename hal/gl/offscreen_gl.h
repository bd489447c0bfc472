// OpenGL without a window: a context with a frame of its own to draw in and to read back.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "hal/gl/gl_functions.h"

namespace cupola {

struct GlDescription {
  std::string context;   // "egl-surfaceless", "egl-gbm", "egl-default" or "osmesa"
  std::string renderer;  // "llvmpipe (LLVM 15.0.6, 256 bits)"
  std::string version;   // "4.5 (Core Profile) Mesa 22.3.6"
  bool es = false;       // OpenGL ES 3.0 or newer: shaders begin with "#version 300 es"; else 3.3 core, "330"
  int width = 0;         // of the frame, pixels
  int height = 0;
};

// Contexts may be many, also of different kinds, each on one thread at a time.
class OffscreenGl {
 public:
  virtual ~OffscreenGl() = default;
  // What is called next on this thread goes to this context, whose frame (8 bits RGBA, 24 bits of depth) is
  // bound and its viewport set. Needed again after another context was current.
  virtual bool make_current() noexcept = 0;
  virtual const GlFunctions& gl() const noexcept = 0;
  // Waits for what was drawn and copies the frame: bytes R, G, B, A, the top row first (clip coordinates y =
  // 1), rows `stride` bytes apart, a multiple of 4 that holds a row; else false, and nothing is written. Only
  // while current; leaves the frame bound for reading and the pixel store as it needs it.
  virtual bool read_back(std::byte* rows, std::ptrdiff_t stride) noexcept = 0;
  virtual const GlDescription& description() const noexcept = 0;
};

// One kind each; they throw std::runtime_error saying why not. The frame has sides from 1 to what the
// renderer can do.
std::unique_ptr<OffscreenGl> open_egl_surfaceless(int width, int height);
std::unique_ptr<OffscreenGl> open_egl_gbm(int width, int height);
std::unique_ptr<OffscreenGl> open_egl_default(int width, int height);
std::unique_ptr<OffscreenGl> open_osmesa(int width, int height);

struct GlRefusal {
  std::string context;
  std::string reason;
};
struct OpenedGl {
  std::unique_ptr<OffscreenGl> context;  // null: none works
  std::vector<GlRefusal> refused;        // what was tried before it
};
// The first that works, in the order above, or the one that is named; a name that is none is refused like one
// that does not work.
OpenedGl open_offscreen_gl(int width, int height, std::string_view context = {});

}  // namespace cupola
