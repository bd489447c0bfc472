// OSMesa: OpenGL in the processor, loaded at run time.
// SPDX-License-Identifier: MIT
#include <array>
#include <stdexcept>
#include <string>
#include <type_traits>

#include <dlfcn.h>

#include "hal/gl/gl_frame.h"
#include "hal/gl/offscreen_gl.h"

// After glcorearb.h: this brings gl.h, which would keep that one from defining all of its types.
#include <GL/osmesa.h>

namespace cupola {
namespace {

struct OsMesa {
  decltype(&OSMesaCreateContextAttribs) create_context;
  decltype(&OSMesaDestroyContext) destroy_context;
  decltype(&OSMesaMakeCurrent) make_current;
  decltype(&OSMesaGetCurrentContext) current_context;
  decltype(&OSMesaGetProcAddress) proc_address;
};

// Kept to itself, as it brings every gl function along under the names that the system's OpenGL has too.
// The library stays loaded for the life of the process: compiled shaders may outlive their contexts.
OsMesa load_osmesa() {
  void* library = nullptr;
  for (const char* name : {"libOSMesa.so.8", "libOSMesa.so"}) {
    if (!library) library = dlopen(name, RTLD_NOW | RTLD_LOCAL | RTLD_NODELETE);
  }
  if (!library) throw std::runtime_error(dlerror());
  OsMesa mesa{};
  const auto load = [&](auto& function, const char* name) {
    function = reinterpret_cast<std::remove_reference_t<decltype(function)>>(dlsym(library, name));
    if (!function) throw std::runtime_error(std::string("libOSMesa has no ") + name);
  };
  load(mesa.create_context, "OSMesaCreateContextAttribs");
  load(mesa.destroy_context, "OSMesaDestroyContext");
  load(mesa.make_current, "OSMesaMakeCurrent");
  load(mesa.current_context, "OSMesaGetCurrentContext");
  load(mesa.proc_address, "OSMesaGetProcAddress");
  return mesa;
}

class OsMesaGl final : public OffscreenGl {
 public:
  OsMesaGl(int width, int height) : mesa_(load_osmesa()) {
    description_ = {"osmesa", {}, {}, false, width, height};
    const int attributes[] = {OSMESA_FORMAT,
                              OSMESA_RGBA,
                              OSMESA_PROFILE,
                              OSMESA_CORE_PROFILE,
                              OSMESA_CONTEXT_MAJOR_VERSION,
                              3,
                              OSMESA_CONTEXT_MINOR_VERSION,
                              3,
                              0};
    context_ = mesa_.create_context(attributes, nullptr);
    if (!context_) throw std::runtime_error("no OpenGL 3.3 core");
    try {
      if (!bind()) throw std::runtime_error("OSMesaMakeCurrent failed");
      frame_.open(mesa_.proc_address, description_);
    } catch (...) {
      destroy();
      throw;
    }
  }
  ~OsMesaGl() override { destroy(); }
  OsMesaGl(const OsMesaGl&) = delete;
  OsMesaGl& operator=(const OsMesaGl&) = delete;

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
  bool bind() noexcept {
    return mesa_.make_current(context_, unused_.data(), GL_UNSIGNED_BYTE, 1, 1) == GL_TRUE;
  }
  void destroy() noexcept {
    if (mesa_.current_context() == context_) mesa_.make_current(nullptr, nullptr, 0, 0, 0);
    mesa_.destroy_context(context_);
  }

  OsMesa mesa_;
  OSMesaContext context_ = nullptr;
  std::array<GLubyte, 4> unused_{};  // OSMesa's own frame, of one pixel
  GlDescription description_;
  GlFrame frame_;
};

}  // namespace

std::unique_ptr<OffscreenGl> open_osmesa(int width, int height) {
  return std::make_unique<OsMesaGl>(width, height);
}

}  // namespace cupola
