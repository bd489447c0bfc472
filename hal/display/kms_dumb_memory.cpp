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
    const int error = fill(buffer, width, height);
    if (error != 0) free(buffer);
    return error;
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
  int fill(KmsBuffer& buffer, int width, int height) noexcept {
    drm_mode_create_dumb create{};
    create.width = static_cast<std::uint32_t>(width);
    create.height = static_cast<std::uint32_t>(height);
    create.bpp = 32;
    if (drmIoctl(card_, DRM_IOCTL_MODE_CREATE_DUMB, &create) != 0) return errno;
    buffer.width = width;
    buffer.height = height;
    buffer.handle = create.handle;
    buffer.stride = create.pitch;
    buffer.bytes = create.size;
    const std::uint32_t handles[4] = {create.handle};
    const std::uint32_t strides[4] = {create.pitch};
    const std::uint32_t offsets[4] = {};
    if (drmModeAddFB2(card_, create.width, create.height, DRM_FORMAT_XRGB8888, handles, strides, offsets,
                      &buffer.framebuffer, 0) != 0) {
      return errno;
    }
    drm_mode_map_dumb map{};
    map.handle = create.handle;
    if (drmIoctl(card_, DRM_IOCTL_MODE_MAP_DUMB, &map) != 0) return errno;
    void* memory = mmap(nullptr, buffer.bytes, PROT_READ | PROT_WRITE, MAP_SHARED, card_,
                        static_cast<off_t>(map.offset));
    if (memory == MAP_FAILED) return errno;
    buffer.data = static_cast<std::byte*>(memory);
    std::memset(memory, 0, buffer.bytes);
    return 0;
  }

  int card_;
};

}  // namespace

std::unique_ptr<KmsMemory> dumb_memory(int card) {
  return std::make_unique<DumbMemory>(card);
}

}  // namespace cupola
