// Memory that a screen shows: dumb buffers, which every driver has, or GBM's.
// SPDX-License-Identifier: MIT
#pragma once

#include <cerrno>
#include <cstddef>
#include <cstdint>
#include <memory>

namespace cupola {

// Little-endian 32-bit words 0x--RRGGBB, or NV12.
struct KmsBuffer {
  int width = 0;  // pixels
  int height = 0;
  std::uint32_t framebuffer = 0;  // the kernel's number for it
  std::byte* data = nullptr;      // while it is open for drawing
  std::ptrdiff_t stride = 0;      // bytes
  std::byte* chroma = nullptr;    // of NV12: rows of U V U V ... of the same stride; null: it is not
  // The maker's own.
  std::uint32_t handle = 0;
  std::size_t bytes = 0;
  void* object = nullptr;
  void* mapping = nullptr;
};

// Buffers of one card. Errors are errno's numbers, 0 being none; nothing throws.
class KmsMemory {
 public:
  virtual ~KmsMemory() = default;
  // A black one, closed. Frees what `buffer` had before.
  virtual int make(KmsBuffer& buffer, int width, int height) noexcept = 0;
  // The same of NV12, whose black is luma `black`, where it can.
  virtual int make_nv12(KmsBuffer& /*buffer*/, int /*width*/, int /*height*/,
                        std::uint8_t /*black*/) noexcept {
    return ENOTSUP;
  }
  virtual void free(KmsBuffer& buffer) noexcept = 0;
  // Between the two the processor draws, and the screen must not look. Open buffers may be opened again.
  virtual int open(KmsBuffer& buffer) noexcept = 0;
  virtual void close(KmsBuffer& buffer) noexcept = 0;
};

// `card` is the card's open descriptor, borrowed for the memory's life.
std::unique_ptr<KmsMemory> dumb_memory(int card);
// Throws std::runtime_error where GBM knows no driver for the card.
std::unique_ptr<KmsMemory> gbm_memory(int card);

}  // namespace cupola
