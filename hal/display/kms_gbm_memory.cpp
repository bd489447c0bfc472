// GBM's buffers: mapped for every frame, as the driver may keep them where the processor cannot see them.
// SPDX-License-Identifier: MIT
#include <cerrno>
#include <cstring>
#include <stdexcept>

#include <drm_fourcc.h>
#include <gbm.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include "hal/display/kms_buffer.h"

namespace cupola {
namespace {

class GbmMemory final : public KmsMemory {
 public:
  explicit GbmMemory(int card) : card_(card), device_(gbm_create_device(card)) {
    if (!device_) throw std::runtime_error("kms: GBM has no driver for this card");
  }
  ~GbmMemory() override { gbm_device_destroy(device_); }
  GbmMemory(const GbmMemory&) = delete;
  GbmMemory& operator=(const GbmMemory&) = delete;

  int make(KmsBuffer& buffer, int width, int height) noexcept override {
    free(buffer);
    const int error = fill(buffer, width, height);
    if (error != 0) free(buffer);
    return error;
  }

  void free(KmsBuffer& buffer) noexcept override {
    close(buffer);
    if (buffer.framebuffer != 0) drmModeRmFB(card_, buffer.framebuffer);
    if (buffer.object) gbm_bo_destroy(static_cast<gbm_bo*>(buffer.object));
    buffer = {};
  }

  int open(KmsBuffer& buffer) noexcept override {
    if (buffer.data) return 0;
    if (!buffer.object) return EINVAL;
    std::uint32_t stride = 0;
    void* data = gbm_bo_map(
        static_cast<gbm_bo*>(buffer.object), 0, 0, static_cast<std::uint32_t>(buffer.width),
        static_cast<std::uint32_t>(buffer.height), GBM_BO_TRANSFER_READ_WRITE, &stride, &buffer.mapping);
    if (!data) return errno != 0 ? errno : ENOMEM;
    buffer.data = static_cast<std::byte*>(data);
    buffer.stride = stride;
    return 0;
  }

  void close(KmsBuffer& buffer) noexcept override {
    if (!buffer.data) return;
    gbm_bo_unmap(static_cast<gbm_bo*>(buffer.object), buffer.mapping);
    buffer.data = nullptr;
    buffer.mapping = nullptr;
  }

 private:
  int fill(KmsBuffer& buffer, int width, int height) noexcept {
    const auto columns = static_cast<std::uint32_t>(width);
    const auto rows = static_cast<std::uint32_t>(height);
    errno = 0;
    gbm_bo* object =
        gbm_bo_create(device_, columns, rows, GBM_FORMAT_XRGB8888, GBM_BO_USE_SCANOUT | GBM_BO_USE_LINEAR);
    if (!object) return errno != 0 ? errno : ENOMEM;
    buffer.object = object;
    buffer.width = width;
    buffer.height = height;
    const std::uint32_t handles[4] = {gbm_bo_get_handle(object).u32};
    const std::uint32_t strides[4] = {gbm_bo_get_stride(object)};
    const std::uint32_t offsets[4] = {gbm_bo_get_offset(object, 0)};
    // "Invalid" means that the driver decides: saying so with the flag is refused.
    const std::uint64_t modifier = gbm_bo_get_modifier(object);
    const std::uint64_t modifiers[4] = {modifier};
    std::uint64_t able = 0;
    const bool with_modifier = modifier != DRM_FORMAT_MOD_INVALID &&
                               drmGetCap(card_, DRM_CAP_ADDFB2_MODIFIERS, &able) == 0 && able != 0;
    const int status = with_modifier ? drmModeAddFB2WithModifiers(card_, columns, rows, DRM_FORMAT_XRGB8888,
                                                                  handles, strides, offsets, modifiers,
                                                                  &buffer.framebuffer, DRM_MODE_FB_MODIFIERS)
                                     : drmModeAddFB2(card_, columns, rows, DRM_FORMAT_XRGB8888, handles,
                                                     strides, offsets, &buffer.framebuffer, 0);
    if (status != 0) return errno;
    const int error = open(buffer);
    if (error != 0) return error;
    for (int y = 0; y < height; ++y) {
      std::memset(buffer.data + y * buffer.stride, 0, std::size_t{4} * static_cast<std::size_t>(width));
    }
    close(buffer);
    return 0;
  }

  int card_;
  gbm_device* device_;
};

}  // namespace

std::unique_ptr<KmsMemory> gbm_memory(int card) {
  return std::make_unique<GbmMemory>(card);
}

}  // namespace cupola
