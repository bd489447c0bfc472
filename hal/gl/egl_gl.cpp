// Contexts through EGL, without a surface: on Mesa's platform for that, a card or the default display.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <fcntl.h>
#include <gbm.h>
#include <unistd.h>

#include "hal/gl/gl_frame.h"
#include "hal/gl/offscreen_gl.h"

namespace cupola {
namespace {

[[noreturn]] void fail(const std::string& what) {
  constexpr const char* kNames[] = {"no error",      "not initialised", "bad access",  "no memory",
                                    "bad attribute", "bad config",      "bad context", "bad current surface",
                                    "bad display",   "bad match",       "bad pixmap",  "bad window",
                                    "bad parameter", "bad surface",     "context lost"};
  const EGLint error = eglGetError();
  const bool known = error > EGL_SUCCESS && error <= EGL_CONTEXT_LOST;
  throw std::runtime_error(known ? what + ": " + kNames[error - EGL_SUCCESS] : what);
}

bool has(const char* extensions, std::string_view name) {
  for (std::string_view rest = extensions ? extensions : ""; !rest.empty();) {
    const std::string_view word = rest.substr(0, rest.find(' '));
    if (word == name) return true;
    rest.remove_prefix(std::min(rest.size(), word.size() + 1));
  }
  return false;
}

EGLDisplay platform_display(EGLenum platform, const char* extension, void* native) {
  if (!has(eglQueryString(EGL_NO_DISPLAY, EGL_EXTENSIONS), extension)) {
    throw std::runtime_error(std::string("EGL has no ") + extension);
  }
  const EGLDisplay display = eglGetPlatformDisplay(platform, native, nullptr);
  if (display == EGL_NO_DISPLAY) fail("no display");
  return display;
}

// A card's render node for GBM, with an EGL display of its own.
class RenderNode {
 public:
  RenderNode() {
    for (int number = 128; number < 192 && !device_; ++number) {
      file_ = open(("/dev/dri/renderD" + std::to_string(number)).c_str(), O_RDWR | O_CLOEXEC);
      if (file_ < 0) continue;
      device_ = gbm_create_device(file_);
      if (!device_) close(file_);
    }
    if (!device_) throw std::runtime_error("no render node in /dev/dri that GBM can use");
  }
  ~RenderNode() {
    if (display != EGL_NO_DISPLAY) eglTerminate(display);
    gbm_device_destroy(device_);
    close(file_);
  }
  RenderNode(const RenderNode&) = delete;
  RenderNode& operator=(const RenderNode&) = delete;
  void* device() const { return device_; }
  EGLDisplay display = EGL_NO_DISPLAY;

 private:
  int file_ = -1;
  gbm_device* device_ = nullptr;
};

class EglGl final : public OffscreenGl {
 public:
  // Displays other than a render node's are shared by all contexts of the process and stay initialised.
  EglGl(const char* name, EGLDisplay display, std::unique_ptr<RenderNode> node, int width, int height)
      : node_(std::move(node)), display_(display) {
    description_ = {name, {}, {}, false, width, height};
    try {
      open();
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~EglGl() override { destroy(); }
  EglGl(const EglGl&) = delete;
  EglGl& operator=(const EglGl&) = delete;

  bool make_current() noexcept override {
    if (!bind()) return false;
    frame_.bind();
    return true;
  }
  const GlFunctions& gl() const noexcept override { return frame_.gl(); }
  bool read_back(std::byte* rows, std::ptrdiff_t stride) noexcept override {
    return frame_.read_back(rows, stride);
  }
  const GlDescription& description() const noexcept override { return description_; }

 private:
  void open() {
    EGLint major = 0;
    EGLint minor = 0;
    if (eglInitialize(display_, &major, &minor) == EGL_FALSE) fail("eglInitialize");
    const char* extensions = eglQueryString(display_, EGL_EXTENSIONS);
    if (!has(extensions, "EGL_KHR_surfaceless_context")) {
      throw std::runtime_error("its contexts want a surface");
    }
    if (!create(EGL_OPENGL_API, EGL_OPENGL_BIT, 3, 3) &&
        !create(EGL_OPENGL_ES_API, EGL_OPENGL_ES3_BIT, 3, 0)) {
      fail("neither OpenGL 3.3 core nor OpenGL ES 3.0");
    }
    if (!bind()) fail("eglMakeCurrent");
    frame_.open(eglGetProcAddress, description_);
  }

  bool create(EGLenum api, EGLint renderable, EGLint major, EGLint minor) {
    if (eglBindAPI(api) == EGL_FALSE) return false;
    const EGLint wanted[] = {EGL_SURFACE_TYPE, 0, EGL_RENDERABLE_TYPE, renderable, EGL_NONE};
    EGLConfig config = EGL_NO_CONFIG_KHR;
    EGLint configs = 0;
    eglChooseConfig(display_, wanted, &config, 1, &configs);
    if (configs == 0 && !has(eglQueryString(display_, EGL_EXTENSIONS), "EGL_KHR_no_config_context")) {
      return false;
    }
    EGLint attributes[] = {EGL_CONTEXT_MAJOR_VERSION,
                           major,
                           EGL_CONTEXT_MINOR_VERSION,
                           minor,
                           EGL_CONTEXT_OPENGL_PROFILE_MASK,
                           EGL_CONTEXT_OPENGL_CORE_PROFILE_BIT,
                           EGL_NONE};
    if (api != EGL_OPENGL_API) attributes[4] = EGL_NONE;  // profiles are OpenGL's alone
    context_ =
        eglCreateContext(display_, configs > 0 ? config : EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, attributes);
    api_ = api;
    return context_ != EGL_NO_CONTEXT;
  }

  // Let go first: EGL does not notice that OSMesa took the thread, and would do nothing.
  bool bind() noexcept {
    release();
    return eglBindAPI(api_) == EGL_TRUE &&
           eglMakeCurrent(display_, EGL_NO_SURFACE, EGL_NO_SURFACE, context_) == EGL_TRUE;
  }
  void release() noexcept {
    const EGLDisplay current = eglGetCurrentDisplay();
    if (current != EGL_NO_DISPLAY) eglMakeCurrent(current, EGL_NO_SURFACE, EGL_NO_SURFACE, EGL_NO_CONTEXT);
  }
  void destroy() noexcept {
    if (context_ == EGL_NO_CONTEXT) return;
    eglBindAPI(api_);
    if (eglGetCurrentContext() == context_) release();
    eglDestroyContext(display_, context_);
  }

  std::unique_ptr<RenderNode> node_;
  EGLDisplay display_;
  EGLContext context_ = EGL_NO_CONTEXT;
  EGLenum api_ = EGL_OPENGL_API;
  GlDescription description_;
  GlFrame frame_;
};

}  // namespace

std::unique_ptr<OffscreenGl> open_egl_surfaceless(int width, int height) {
  const EGLDisplay display =
      platform_display(EGL_PLATFORM_SURFACELESS_MESA, "EGL_MESA_platform_surfaceless", EGL_DEFAULT_DISPLAY);
  return std::make_unique<EglGl>("egl-surfaceless", display, nullptr, width, height);
}

std::unique_ptr<OffscreenGl> open_egl_gbm(int width, int height) {
  auto node = std::make_unique<RenderNode>();
  node->display = platform_display(EGL_PLATFORM_GBM_KHR, "EGL_KHR_platform_gbm", node->device());
  const EGLDisplay display = node->display;
  return std::make_unique<EglGl>("egl-gbm", display, std::move(node), width, height);
}

std::unique_ptr<OffscreenGl> open_egl_default(int width, int height) {
  const EGLDisplay display = eglGetDisplay(EGL_DEFAULT_DISPLAY);
  if (display == EGL_NO_DISPLAY) fail("no display");
  return std::make_unique<EglGl>("egl-default", display, nullptr, width, height);
}

}  // namespace cupola
