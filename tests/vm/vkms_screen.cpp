// One commit of the write-back connector into a dumb buffer, and another to let it go.
// SPDX-License-Identifier: MIT
#include "tests/vm/vkms_screen.h"

#include <drm_fourcc.h>
#include <fcntl.h>
#include <poll.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

#include <cstring>
#include <filesystem>
#include <fstream>
#include <string>

#include <gtest/gtest.h>

#include "hal/display/kms_buffer.h"

namespace cupola {
namespace {

std::uint32_t property(int card, std::uint32_t object, const std::string& name) {
  std::uint32_t found = 0;
  drmModeObjectProperties* all = drmModeObjectGetProperties(card, object, DRM_MODE_OBJECT_CONNECTOR);
  for (std::uint32_t i = 0; all && i < all->count_props; ++i) {
    drmModePropertyRes* one = drmModeGetProperty(card, all->props[i]);
    if (one && one->name == name) found = one->prop_id;
    drmModeFreeProperty(one);
  }
  drmModeFreeObjectProperties(all);
  return found;
}

std::uint32_t write_back_connector(int card, drmModeRes* resources) {
  for (int i = 0; i < resources->count_connectors; ++i) {
    drmModeConnector* connector = drmModeGetConnectorCurrent(card, resources->connectors[i]);
    const bool found = connector && connector->connector_type == DRM_MODE_CONNECTOR_WRITEBACK;
    drmModeFreeConnector(connector);
    if (found) return resources->connectors[i];
  }
  return 0;
}

}  // namespace

void plug_vkms(bool in) {
  std::ofstream status("/sys/class/drm/card0-Virtual-1/status");
  status << (in ? "on" : "off") << std::flush;
  EXPECT_TRUE(status.good());
}

int vkms_descriptor() {
  int first = -1;
  for (const auto& entry : std::filesystem::directory_iterator("/proc/self/fd")) {
    std::error_code error;
    if (std::filesystem::read_symlink(entry.path(), error) != "/dev/dri/card0") continue;
    const int number = std::stoi(entry.path().filename());
    if (first < 0 || number < first) first = number;
  }
  return first;
}

int flip_vkms(std::uint32_t framebuffer) {
  const int card = vkms_descriptor();
  drmModeRes* resources = drmModeGetResources(card);
  const int result =
      drmModePageFlip(card, resources->crtcs[0], framebuffer, DRM_MODE_PAGE_FLIP_EVENT, nullptr);
  drmModeFreeResources(resources);
  return -result;
}

std::vector<std::uint32_t> vkms_screen(int width, int height) {
  const int card = vkms_descriptor();
  drmSetClientCap(card, DRM_CLIENT_CAP_WRITEBACK_CONNECTORS, 1);
  drmModeRes* resources = drmModeGetResources(card);
  const std::uint32_t connector = write_back_connector(card, resources);
  const std::uint32_t crtc = resources->crtcs[0];
  drmModeFreeResources(resources);
  const auto memory = dumb_memory(card);
  KmsBuffer into;
  EXPECT_EQ(memory->make(into, width, height), 0);

  int fence = -1;
  drmModeAtomicReq* request = drmModeAtomicAlloc();
  drmModeAtomicAddProperty(request, connector, property(card, connector, "CRTC_ID"), crtc);
  drmModeAtomicAddProperty(request, connector, property(card, connector, "WRITEBACK_FB_ID"),
                           into.framebuffer);
  drmModeAtomicAddProperty(request, connector, property(card, connector, "WRITEBACK_OUT_FENCE_PTR"),
                           reinterpret_cast<std::uintptr_t>(&fence));
  EXPECT_EQ(drmModeAtomicCommit(card, request, DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr), 0);
  pollfd written{fence, POLLIN, 0};
  EXPECT_EQ(poll(&written, 1, 3000), 1);
  if (fence >= 0) close(fence);

  std::vector<std::uint32_t> words;
  for (int y = 0; y < height && into.data; ++y) {
    words.resize(static_cast<std::size_t>((y + 1) * width));
    std::memcpy(words.data() + static_cast<std::size_t>(y * width), into.data + y * into.stride,
                std::size_t{4} * static_cast<std::size_t>(width));
  }
  drmModeAtomicSetCursor(request, 0);
  drmModeAtomicAddProperty(request, connector, property(card, connector, "CRTC_ID"), 0);
  EXPECT_EQ(drmModeAtomicCommit(card, request, DRM_MODE_ATOMIC_ALLOW_MODESET, nullptr), 0);
  drmModeAtomicFree(request);
  memory->free(into);
  return words;
}

}  // namespace cupola
