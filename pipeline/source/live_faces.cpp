// Between cameras and warp nothing is copied but the last picture of a camera that is lost.
// SPDX-License-Identifier: MIT
#include "pipeline/source/live_faces.h"

#include <algorithm>
#include <cstring>
#include <utility>

#include "pipeline/source/face_part.h"
#include "pipeline/source/lettering.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

constexpr std::uint8_t kSlateGrey = 40;
constexpr std::uint8_t kSlateLetters = 140;
constexpr std::uint8_t kNoColour = 128;
constexpr int kKept = -1;  // as a frame's buffer: nobody's

// The picture's name in the middle of dark grey, legible in the dome and no brighter than it needs to be.
void draw_slate(const std::string& name, const MutableNativeImage& slate) {
  const std::vector<Label> labels = {{name, {0, 0, -1}, {0, 1, 0}, 0.2, 0.03}};
  const Lettering letters(labels);
  const Size size = slate.size;
  const double scale = 2.0 / std::min(size.width, size.height);
  for (int y = 0; y < size.height; ++y) {
    for (int x = 0; x < size.width; ++x) {
      const Vec3 direction = glm::normalize(
          Vec3{scale * (x + 0.5 - size.width / 2.0), scale * (size.height / 2.0 - y - 0.5), -1.0});
      const std::uint8_t grey = letters.distance(direction) < 0.0 ? kSlateLetters : kSlateGrey;
      for (int channel = 0; channel < (is_rgb(slate.layout) ? 3 : 1); ++channel)
        *sample_at(slate, channel, x, y) = grey;
    }
  }
  const Size chroma = chroma_size(slate.layout, size);
  for (int channel = 1; channel < 3; ++channel) {
    for (int y = 0; y < chroma.height; ++y) {
      for (int x = 0; x < chroma.width; ++x) *sample_at(slate, channel, x, y) = kNoColour;
    }
  }
}

Size size_of(const TexelBox& box) {
  return {box.x1 - box.x0, box.y1 - box.y0};
}

CameraFrame frame_of(const NativeImage& image, const CameraFrame& like) {
  CameraFrame frame = like;
  frame.buffer = kKept;
  for (std::size_t p = 0; p < plane_count(image.layout); ++p) {
    frame.planes[p] = {image.planes[p].data, image.planes[p].stride, 0, -1, 0};
  }
  return frame;
}

// Returns the bytes copied.
std::uint64_t copy(const NativeImage& from, const MutableNativeImage& to) {
  std::uint64_t bytes = 0;
  for (std::size_t p = 0; p < plane_count(from.layout); ++p) {
    const Size rows = plane_bytes(from.layout, from.size, p);
    for (int y = 0; y < rows.height; ++y) {
      std::memcpy(to.planes[p].row(y), from.planes[p].row(y), static_cast<std::size_t>(rows.width));
    }
    bytes += static_cast<std::uint64_t>(rows.width) * static_cast<std::uint64_t>(rows.height);
  }
  return bytes;
}

}  // namespace

std::optional<NativeLayout> layout_of(CameraFormat format) {
  switch (format) {
    case CameraFormat::kYuyv:
      return NativeLayout::kYuyv;
    case CameraFormat::kUyvy:
      return NativeLayout::kUyvy;
    case CameraFormat::kNv12:
      return NativeLayout::kNv12;
    case CameraFormat::kP010:
      return NativeLayout::kP010;
    case CameraFormat::kI420:
    case CameraFormat::kGrey:
      return NativeLayout::kI420;
    case CameraFormat::kI422:
      return NativeLayout::kI422;
    case CameraFormat::kRgb24:
      return NativeLayout::kRgb24;
    case CameraFormat::kBgr24:
      return NativeLayout::kBgr24;
    case CameraFormat::kXrgb32:
      return NativeLayout::kXrgb32;
    default:
      return std::nullopt;
  }
}

YuvColour colour_of(const CameraMode& mode) {
  return {mode.bt709 ? YuvMatrix::kBt709 : YuvMatrix::kBt601,
          mode.full_range ? YuvRange::kFull : YuvRange::kLimited};
}

LiveFaces::LiveFaces(std::vector<LiveView> views, Clock& clock, const SyncSettings& settings)
    : views_(std::move(views)),
      clock_(clock),
      sync_(views_.size(), settings),
      shown_(views_.size()),
      descriptors_(views_.size(), -1) {
  for (const LiveView& view : views_) {
    const NativeLayout layout = layout_of(view.mode.format).value();
    const Size size{view.mode.width, view.mode.height};
    const auto chroma_width = static_cast<std::size_t>(chroma_size(layout, size).width);
    grey_row_.resize(std::max(grey_row_.size(), chroma_width), kNoColour);
    slates_.emplace_back(layout, colour_of(view.mode), size);
    draw_slate(view.name, slates_.back().pixels());
    kept_.emplace_back(layout, colour_of(view.mode), size);
    sent_.push_back({0, 0, size.width, size.height});
    faces_.push_back(as_const(slates_.back().pixels()));
  }
}

LiveFaces::~LiveFaces() {
  for (std::size_t v = 0; v < views_.size(); ++v) sync_.lose(v, nullptr);
}

void LiveFaces::gather(nanoseconds deadline) noexcept {
  for (;;) {
    nanoseconds wake = deadline;
    for (std::size_t v = 0; v < views_.size(); ++v) {
      if (!views_[v].camera) continue;
      collect(v);
      descriptors_[v] = views_[v].camera->descriptor();
      wake = std::min(wake, views_[v].camera->deadline());
    }
    if (clock_.now() >= deadline) return;
    clock_.wait(descriptors_, wake);
  }
}

void LiveFaces::collect(std::size_t view) noexcept {
  CameraWatch& camera = *views_[view].camera;
  CameraFrame frame;
  for (;;) {
    switch (camera.poll(frame)) {
      case CameraWatch::Poll::kFrame:
        if (const auto place = place_of(camera.mode(), views_[view].mode);
            place && contains(*place, views_[view].needed)) {
          sent_[view] = *place;
          sync_.offer(view, frame, clock_.now());
        } else {
          camera.give_back(frame);
          ++counts_.unlike;
        }
        give_back_spent();
        break;
      case CameraWatch::Poll::kLost:
        lose(view);
        break;
      case CameraWatch::Poll::kBack:
        break;
      case CameraWatch::Poll::kNothing:
        return;
    }
  }
}

// Its buffers go with the stream: what is shown of it is saved first.
void LiveFaces::lose(std::size_t view) noexcept {
  const SyncedFace& shown = sync_.faces()[view];
  if (shown.state == SyncedFace::State::kSlate) return sync_.lose(view, nullptr);
  const MutableNativeImage& kept = kept_[view].pixels();
  if (shown.frame.buffer != kKept) {
    const TexelBox& sent = sent_[view];
    counts_.pixel_bytes_copied += copy(part_of(faces_[view], sent.x0, sent.y0, size_of(sent)),
                                       part_of(kept, sent.x0, sent.y0, size_of(sent)));
  }
  const CameraFrame frame = frame_of(as_const(kept), shown.frame);
  sync_.lose(view, &frame);
  faces_[view] = as_const(kept);
}

// What the view shows of the frame.
NativeImage LiveFaces::image_of(std::size_t view, const CameraFrame& frame) noexcept {
  NativeImage image = as_const(slates_[view].pixels());
  for (std::size_t p = 0; p < plane_count(image.layout); ++p) {
    const CameraPlane& plane = frame.planes[p];
    image.planes[p] = {plane.data ? plane.data : grey_row_.data(), plane.stride};
  }
  if (frame.buffer == kKept) return image;
  const TexelBox& sent = sent_[view];
  return whole_of(image, sent.x0, sent.y0, image.size);
}

void LiveFaces::give_back_spent() noexcept {
  while (const auto spent = sync_.spent()) {
    if (spent->frame.buffer != kKept) views_[spent->camera].camera->give_back(spent->frame);
  }
}

bool LiveFaces::choose() noexcept {
  const bool changed = sync_.choose(clock_.now());
  changed_ = 0;
  for (std::size_t v = 0; changed && v < views_.size(); ++v) {
    const SyncedFace& face = sync_.faces()[v];
    const bool slate = face.state == SyncedFace::State::kSlate;
    faces_[v] = slate ? as_const(slates_[v].pixels()) : image_of(v, face.frame);
    // A slate stays as it is; a camera's picture is another one when it was taken at another time.
    const Shown now = slate ? Shown{.slate = true}
                            : Shown{false, face.frame.buffer, face.frame.sequence, face.frame.captured_at};
    if (now != std::exchange(shown_[v], now)) changed_ |= 1U << v;
  }
  give_back_spent();
  return changed;
}

}  // namespace cupola
