// A framebuffer object of renderbuffers. OpenGL's rows run upwards; ours are turned over after reading.
// SPDX-License-Identifier: MIT
#include "hal/gl/gl_frame.h"

#include <algorithm>
#include <array>
#include <cstring>
#include <stdexcept>
#include <string>

namespace cupola {
namespace {

void swap_rows(std::byte* a, std::byte* b, std::size_t bytes) {
  std::array<std::byte, 4096> piece;
  for (std::size_t at = 0; at < bytes; at += piece.size()) {
    const std::size_t size = std::min(piece.size(), bytes - at);
    std::memcpy(piece.data(), a + at, size);
    std::memcpy(a + at, b + at, size);
    std::memcpy(b + at, piece.data(), size);
  }
}

}  // namespace

void GlFrame::open(GlLoader loader, GlDescription& description) {
  if (const char* missing = load_gl(gl_, loader)) {
    throw std::runtime_error(std::string("there is no ") + missing);
  }
  const auto text = [&](GLenum what) {
    const auto* words = reinterpret_cast<const char*>(gl_.get_string(what));
    return std::string(words ? words : "");
  };
  description.renderer = text(GL_RENDERER);
  description.version = text(GL_VERSION);
  description.es = description.version.starts_with("OpenGL ES");
  width_ = description.width;
  height_ = description.height;
  GLint most = 0;
  gl_.get_integerv(GL_MAX_RENDERBUFFER_SIZE, &most);
  GLint viewport[2] = {};
  gl_.get_integerv(GL_MAX_VIEWPORT_DIMS, viewport);
  if (width_ < 1 || height_ < 1 || width_ > std::min(most, viewport[0]) ||
      height_ > std::min(most, viewport[1])) {
    throw std::runtime_error("expected a frame with sides from 1 to " +
                             std::to_string(std::min({most, viewport[0], viewport[1]})));
  }
  GLuint colour_and_depth[2] = {};
  gl_.gen_renderbuffers(2, colour_and_depth);
  gl_.bind_renderbuffer(GL_RENDERBUFFER, colour_and_depth[0]);
  gl_.renderbuffer_storage(GL_RENDERBUFFER, GL_RGBA8, width_, height_);
  gl_.bind_renderbuffer(GL_RENDERBUFFER, colour_and_depth[1]);
  gl_.renderbuffer_storage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width_, height_);
  gl_.gen_framebuffers(1, &framebuffer_);
  bind();
  gl_.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, colour_and_depth[0]);
  gl_.framebuffer_renderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, colour_and_depth[1]);
  if (gl_.get_error() != GL_NO_ERROR ||
      gl_.check_framebuffer_status(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE) {
    throw std::runtime_error("there is no memory for a frame of " + std::to_string(width_) + "x" +
                             std::to_string(height_));
  }
}

void GlFrame::bind() const noexcept {
  gl_.bind_framebuffer(GL_FRAMEBUFFER, framebuffer_);
  gl_.viewport(0, 0, width_, height_);
}

bool GlFrame::read_back(std::byte* rows, std::ptrdiff_t stride) const noexcept {
  const auto row_bytes = std::size_t{4} * static_cast<std::size_t>(width_);
  if (!rows || stride % 4 != 0 || stride < static_cast<std::ptrdiff_t>(row_bytes)) return false;
  gl_.bind_framebuffer(GL_READ_FRAMEBUFFER, framebuffer_);
  gl_.read_buffer(GL_COLOR_ATTACHMENT0);
  gl_.bind_buffer(GL_PIXEL_PACK_BUFFER, 0);
  gl_.pixel_storei(GL_PACK_ALIGNMENT, 4);
  gl_.pixel_storei(GL_PACK_ROW_LENGTH, static_cast<GLint>(stride / 4));
  gl_.pixel_storei(GL_PACK_SKIP_ROWS, 0);
  gl_.pixel_storei(GL_PACK_SKIP_PIXELS, 0);
  while (gl_.get_error() != GL_NO_ERROR) {
  }
  gl_.read_pixels(0, 0, width_, height_, GL_RGBA, GL_UNSIGNED_BYTE, rows);
  if (gl_.get_error() != GL_NO_ERROR) return false;
  for (int y = 0; y < height_ / 2; ++y) {
    swap_rows(rows + y * stride, rows + (height_ - 1 - y) * stride, row_bytes);
  }
  return true;
}

}  // namespace cupola
