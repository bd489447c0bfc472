// Dumb buffers: mapped once, for good.
// SPDX-License-Identifier: MIT
#include <cerrno>
#include <cstring>

#include <drm_fourcc.h>
#include <sys/mman.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "hal/display/kms_buffer.h"

namespace cupola {
namespace {

class DumbMemory final : public KmsMemory {
 public:
  explicit DumbMemory(int card) : card_(card) {}

  int make(KmsBuffer& buffer, int width, int height) noexcept override {
    free(buffer);
    buffer.width = width;
    buffer.height = height;
    int error = take(buffer, 32, width, height);
    if (error == 0) error = add_framebuffer(buffer, DRM_FORMAT_XRGB8888, 0);
    if (error == 0) error = map(buffer);
    if (error != 0) {
      free(buffer);
    } else {
      std::memset(buffer.data, 0, buffer.bytes);
    }
    return error;
  }

  // Chroma behind luma in the same memory, as every driver can have it.
  int make_nv12(KmsBuffer& buffer, int width, int height, std::uint8_t black) noexcept override {
    free(buffer);
    buffer.width = width;
    buffer.height = height;
    int error = take(buffer, 8, (width + 1) / 2 * 2, height + (height + 1) / 2);
    const std::ptrdiff_t luma = buffer.stride * height;  // bytes
    if (error == 0) error = add_framebuffer(buffer, DRM_FORMAT_NV12, static_cast<std::uint32_t>(luma));
    if (error == 0) error = map(buffer);
    if (error != 0) {
      free(buffer);
      return error;
    }
    buffer.chroma = buffer.data + luma;
    std::memset(buffer.data, black, static_cast<std::size_t>(luma));
    std::memset(buffer.chroma, 128, buffer.bytes - static_cast<std::size_t>(luma));
    return 0;
  }

  void free(KmsBuffer& buffer) noexcept override {
    if (buffer.framebuffer != 0) drmModeRmFB(card_, buffer.framebuffer);
    if (buffer.data) munmap(buffer.data, buffer.bytes);
    drm_mode_destroy_dumb destroy{buffer.handle};
    if (buffer.handle != 0) drmIoctl(card_, DRM_IOCTL_MODE_DESTROY_DUMB, &destroy);
    buffer = {};
  }

  int open(KmsBuffer& buffer) noexcept override { return buffer.data ? 0 : EINVAL; }
  void close(KmsBuffer&) noexcept override {}

 private:
  int take(KmsBuffer& buffer, std::uint32_t bits, int columns, int rows) noexcept {
    drm_mode_create_dumb create{};
    create.width = static_cast<std::uint32_t>(columns);
    create.height = static_cast<std::uint32_t>(rows);
    create.bpp = bits;
    if (drmIoctl(card_, DRM_IOCTL_MODE_CREATE_DUMB, &create) != 0) return errno;
    buffer.handle = create.handle;
    buffer.stride = create.pitch;
    buffer.bytes = create.size;
    return 0;
  }

  // `chroma`: bytes before it, of formats that have it apart; else 0.
  int add_framebuffer(KmsBuffer& buffer, std::uint32_t format, std::uint32_t chroma) noexcept {
    const bool apart = chroma != 0;
    const auto stride = static_cast<std::uint32_t>(buffer.stride);
    const std::uint32_t handles[4] = {buffer.handle, apart ? buffer.handle : 0};
    const std::uint32_t strides[4] = {stride, apart ? stride : 0};
    const std::uint32_t offsets[4] = {0, chroma};
    const int status = drmModeAddFB2(card_, static_cast<std::uint32_t>(buffer.width),
                                     static_cast<std::uint32_t>(buffer.height), format, handles, strides,
                                     offsets, &buffer.framebuffer, 0);
    return status == 0 ? 0 : errno;
  }

  int map(KmsBuffer& buffer) noexcept {
    drm_mode_map_dumb map{};
    map.handle = buffer.handle;
    if (drmIoctl(card_, DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) return errno;
    void* memory = mmap(nullptr, buffer.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, card_,
                        static_cast<off_t>(map.offset));
    if (memory == MAP_FAILED) return errno;
    buffer.data = static_cast<std::byte*>(memory);
    return 0;
  }

  int card_;
};

}  // namespace

std::unique_ptr<KmsMemory> dumb_memory(int card) {
  return std::make_unique<DumbMemory>(card);
}

}  // namespace cupola
