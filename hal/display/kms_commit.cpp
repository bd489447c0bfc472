// Atomic commits from fixed arrays: libdrm's own would allocate for every frame.
// SPDX-License-Identifier: MIT
#include "hal/display/kms_commit.h"

#include <array>
#include <cassert>
#include <cerrno>
#include <cstddef>
#include <cstring>

#include <unistd.h>
#include <xf86drm.h>
#include <xf86drmMode.h>

namespace cupola {
namespace {

// At most 8 objects with 32 properties in all, object by object.
class Request {
 public:
  void set(std::uint32_t object, std::uint32_t property, std::uint64_t value) {
    if (objects_ == 0 || object_[objects_ - 1] != object) {
      assert(objects_ < object_.size());
      object_[objects_++] = object;
    }
    assert(properties_ < property_.size());
    ++count_[objects_ - 1];
    property_[properties_] = property;
    value_[properties_++] = value;
  }

  int commit(int card, std::uint32_t flags, std::uint64_t number = 0) {
    drm_mode_atomic request{};
    request.flags = flags;
    request.count_objs = static_cast<std::uint32_t>(objects_);
    request.objs_ptr = address(object_.data());
    request.count_props_ptr = address(count_.data());
    request.props_ptr = address(property_.data());
    request.prop_values_ptr = address(value_.data());
    request.user_data = number;
    return drmIoctl(card, DRM_IOCTL_MODE_ATOMIC, &request) == 0 ? 0 : errno;
  }

 private:
  static std::uint64_t address(const void* pointer) { return reinterpret_cast<std::uintptr_t>(pointer); }

  std::array<std::uint32_t, 8> object_{};
  std::array<std::uint32_t, 8> count_{};
  std::array<std::uint32_t, 32> property_{};
  std::array<std::uint64_t, 32> value_{};
  std::size_t objects_ = 0;
  std::size_t properties_ = 0;
};

constexpr std::size_t kMostNeighbours = 5;

void set_picture(Request& request, const KmsPipe& pipe, const KmsBuffer& buffer) {
  request.set(pipe.plane, pipe.plane_property.fb_id, buffer.framebuffer);
  if (!buffer.chroma) return;
  const auto& colour = pipe.nv12_colour;
  if (colour.encoding != 0) request.set(pipe.plane, colour.encoding, colour.encoding_value);
  if (colour.range != 0) request.set(pipe.plane, colour.range, colour.range_value);
}

}  // namespace

int commit_flip(const KmsFile& card, const KmsPipe& pipe, const KmsBuffer& buffer,
                std::uint64_t number) noexcept {
  Request request;
  set_picture(request, pipe, buffer);
  return request.commit(card.get(), DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_PAGE_FLIP_EVENT, number);
}

int test_flip(const KmsFile& card, const KmsPipe& pipe, const KmsBuffer& buffer) noexcept {
  Request request;
  set_picture(request, pipe, buffer);
  return request.commit(card.get(), DRM_MODE_ATOMIC_TEST_ONLY);
}

int commit_mode(const KmsFile& card, const KmsPipe& pipe, std::uint32_t blob, const KmsBuffer& buffer,
                std::uint64_t number) noexcept {
  const auto width = static_cast<std::uint64_t>(buffer.width);
  const auto height = static_cast<std::uint64_t>(buffer.height);
  Request request;
  for (std::size_t i = 0; i < pipe.neighbours.size() && i < kMostNeighbours; ++i) {
    request.set(pipe.neighbours[i], pipe.connector_property.crtc_id, 0);
  }
  request.set(pipe.connector, pipe.connector_property.crtc_id, pipe.crtc);
  if (pipe.connector_property.link_status != 0) {
    request.set(pipe.connector, pipe.connector_property.link_status, 0);  // good: trains the link again
  }
  request.set(pipe.crtc, pipe.crtc_property.mode_id, blob);
  request.set(pipe.crtc, pipe.crtc_property.active, 1);
  set_picture(request, pipe, buffer);
  request.set(pipe.plane, pipe.plane_property.crtc_id, pipe.crtc);
  request.set(pipe.plane, pipe.plane_property.src_x, 0);
  request.set(pipe.plane, pipe.plane_property.src_y, 0);
  request.set(pipe.plane, pipe.plane_property.src_w, width << 16);  // Q16
  request.set(pipe.plane, pipe.plane_property.src_h, height << 16);
  request.set(pipe.plane, pipe.plane_property.crtc_x, 0);
  request.set(pipe.plane, pipe.plane_property.crtc_y, 0);
  request.set(pipe.plane, pipe.plane_property.crtc_w, width);
  request.set(pipe.plane, pipe.plane_property.crtc_h, height);
  return request.commit(card.get(),
                        DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_ATOMIC_ALLOW_MODESET | DRM_MODE_PAGE_FLIP_EVENT,
                        number);
}

int commit_off(const KmsFile& card, const KmsPipe& pipe) noexcept {
  Request request;
  request.set(pipe.connector, pipe.connector_property.crtc_id, 0);
  request.set(pipe.crtc, pipe.crtc_property.mode_id, 0);
  request.set(pipe.crtc, pipe.crtc_property.active, 0);
  request.set(pipe.plane, pipe.plane_property.fb_id, 0);
  request.set(pipe.plane, pipe.plane_property.crtc_id, 0);
  return request.commit(card.get(), DRM_MODE_ATOMIC_NONBLOCK | DRM_MODE_ATOMIC_ALLOW_MODESET);
}

bool take_flip(const KmsFile& card, std::uint64_t number, std::chrono::nanoseconds& flipped_at) noexcept {
  alignas(drm_event_vblank) std::array<std::byte, 1024> events{};
  bool flipped = false;
  for (;;) {
    // The card's file does not block: when it has no (more) events, it says so.
    const ssize_t size = read(card.get(), events.data(), events.size());
    if (size <= 0) return flipped;
    for (std::size_t at = 0; at + sizeof(drm_event) <= static_cast<std::size_t>(size);) {
      drm_event event;
      std::memcpy(&event, events.data() + at, sizeof event);
      if (event.type == DRM_EVENT_FLIP_COMPLETE && at + sizeof(drm_event_vblank) <= events.size()) {
        drm_event_vblank flip;
        std::memcpy(&flip, events.data() + at, sizeof flip);
        if (flip.user_data == number) {
          flipped_at = std::chrono::seconds(flip.tv_sec) + std::chrono::microseconds(flip.tv_usec);
          flipped = true;
        }
      }
      if (event.length < sizeof event) return flipped;
      at += event.length;
    }
  }
}

}  // namespace cupola
