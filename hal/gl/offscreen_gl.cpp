// Trying one after the other.
// SPDX-License-Identifier: MIT
#include "hal/gl/offscreen_gl.h"

#include <stdexcept>

namespace cupola {
namespace {

struct Kind {
  const char* name;
  std::unique_ptr<OffscreenGl> (*open)(int width, int height);
};
constexpr Kind kKinds[] = {{"egl-surfaceless", open_egl_surfaceless},
                           {"egl-gbm", open_egl_gbm},
                           {"egl-default", open_egl_default},
                           {"osmesa", open_osmesa}};

}  // namespace

OpenedGl open_offscreen_gl(int width, int height, std::string_view context) {
  OpenedGl opened;
  for (const Kind& kind : kKinds) {
    if (!context.empty() && context != kind.name) continue;
    try {
      opened.context = kind.open(width, height);
      return opened;
    } catch (const std::runtime_error& error) {
      opened.refused.push_back({kind.name, error.what()});
    }
  }
  if (opened.refused.empty()) {
    opened.refused.push_back(
        {std::string(context), "expected egl-surfaceless, egl-gbm, egl-default or osmesa"});
  }
  return opened;
}

}  // namespace cupola
