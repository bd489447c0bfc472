// One of four things a frame; each knows what the display's buffers hold of the ones before.
// SPDX-License-Identifier: MIT
#include "firmware/frame_presenter.h"

#include <algorithm>
#include <utility>

namespace cupola {

using Change = FrameMaker::Change;

namespace {

constexpr int kOldest = 64;  // presents; no display has so many buffers
constexpr std::size_t kTimes = 65536;

MutableImage image_of(const DisplayBuffer& buffer) {
  return {PixelFormat::kXrgb8888, {buffer.width, buffer.height}, {{{buffer.data, buffer.stride}, {}, {}}}};
}

MutableNativeImage nv12_of(const DisplayBuffer& buffer, YuvColour colour) {
  const auto plane = [&](std::byte* data) {
    return Plane<std::uint8_t>{reinterpret_cast<std::uint8_t*>(data), buffer.stride};
  };
  return {NativeLayout::kNv12,
          colour,
          {buffer.width, buffer.height},
          {plane(buffer.data), plane(buffer.chroma), {}}};
}

ScanoutColour scanout_of(YuvColour colour) {
  return {colour.matrix == YuvMatrix::kBt709, colour.range == YuvRange::kFull};
}

}  // namespace

FramePresenter::FramePresenter(Display& display, Clock& clock, ControlLink& link, LoopCounts& counts)
    : display_(display), clock_(clock), link_(link), counts_(counts), warp_times_(kTimes) {}

void FramePresenter::prepare(const FrameMaker& show) {
  const DisplayBuffer buffer = display_.back_buffer();
  if (buffer.data) undimmed_ = ImageBuffer(PixelFormat::kXrgb8888, {buffer.width, buffer.height});
  nv12_ = show.nv12_colour();
  if (!nv12_ || display_.prepare_nv12(scanout_of(*nv12_))) return;
  nv12_.reset();
  link_.log.warn(Topic::kDisplay, "the display takes no NV12: frames are XRGB8888");
}

void FramePresenter::begin_show() noexcept {
  another_show_ = true;
  since_other_ = 0;
  undimmed_holds_ = false;
}

Presented FramePresenter::present(const Frame& frame) noexcept {
  warp_begun_ = warp_done_ = clock_.now();
  const bool looked_at = link_.preview && link_.preview->wants(frame.flip);
  const ImageBuffer* pattern = link_.patterns ? link_.patterns->picture(frame.wishes.pattern()) : nullptr;
  if (link_.screenshots && frame.wishes.screenshot()) link_.screenshots->ask();
  if (link_.screenshots && !screenshot_) screenshot_ = link_.screenshots->due();
  const bool dark = frame.dark || frame.wishes.black();
  if ((dark || pattern) && frame.change == Change::kNew) undimmed_holds_ = false;  // of what is not seen
  if (dark) return present_black(frame);
  if (pattern) return present_pattern(frame, *pattern);

  const bool nv12 = nv12_ && frame.show.gives_nv12() && frame.wishes.light() == kWholeWeight && !screenshot_;
  const bool uncover = (black_ || pattern_ || another_show_) && frame.change != Change::kFailed;
  const bool relit = frame.wishes.light() != light_ || frame.wishes.light() != kWholeWeight;
  if (frame.change == Change::kNew || (frame.change == Change::kUnchanged && looked_at) || uncover || relit ||
      screenshot_ || !stands_) {
    return nv12 ? present_nv12(frame) : present_picture(frame);
  }
  const Presented presented = display_.repeat(frame.flip);
  if (presented.result == Present::kShown) ++counts_.frames_unchanged;
  return presented;
}

// Drawn once; then it stands.
Presented FramePresenter::present_black(const Frame& frame) noexcept {
  if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy_black(frame.flip);
  if (screenshot_) give_screenshot(frame, 0);
  if (black_) return display_.repeat(frame.flip);
  const DisplayBuffer buffer = display_.back_buffer();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  for (int y = 0; y < buffer.height; ++y) {
    auto* row = reinterpret_cast<std::uint32_t*>(buffer.data + y * buffer.stride);
    std::fill_n(row, buffer.width, 0xff000000U);
  }
  stands_ = black_ = true;
  pattern_ = nullptr;
  since_other_ = 0;
  return display_.present(frame.flip);
}

// Drawn once, and again when it or the light changes; then it stands.
Presented FramePresenter::present_pattern(const Frame& frame, const ImageBuffer& pattern) noexcept {
  if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy(pattern.pixels(), frame.flip);
  if (screenshot_) {
    dim(pattern.pixels(), frame.wishes.light(), screenshot_->frame.pixels(), frame.pool);
    give_screenshot(frame, kWholeWeight);
  }
  const std::size_t laid = link_.patterns->laid();
  if (pattern_ == &pattern && pattern_laid_ == laid && light_ == frame.wishes.light()) {
    return display_.repeat(frame.flip);
  }
  const DisplayBuffer buffer = display_.back_buffer();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  light_ = frame.wishes.light();
  dim(pattern.pixels(), light_, image_of(buffer), frame.pool);
  pattern_ = &pattern;
  pattern_laid_ = laid;
  stands_ = true;
  black_ = false;
  since_other_ = 0;
  return display_.present(frame.flip);
}

Presented FramePresenter::present_picture(const Frame& frame) noexcept {
  const DisplayBuffer buffer = display_.back_buffer();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  if (std::exchange(was_nv12_, false)) since_other_ = 0;
  light_ = frame.wishes.light();
  warp_into(image_of(buffer), buffer.age, frame);
  if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy(Image(image_of(buffer)), frame.flip);
  const Presented presented = display_.present(frame.flip);
  if (screenshot_) {
    std::swap(screenshot_->frame, undimmed_);
    undimmed_holds_ = false;
    give_screenshot(frame, light_);
  }
  note_picture();
  return presented;
}

// No conversion: the screen makes it.
Presented FramePresenter::present_nv12(const Frame& frame) noexcept {
  const DisplayBuffer buffer = display_.back_nv12();
  if (!buffer.data) return {Present::kLost, clock_.now()};
  if (!std::exchange(was_nv12_, true)) since_other_ = 0;
  light_ = kWholeWeight;
  const MutableNativeImage image = nv12_of(buffer, *nv12_);
  warp_begun_ = clock_.now();
  counts_.tiles += frame.show.warp_nv12(image, buffer.age <= since_other_ ? buffer.age : 0);
  note_warp();
  undimmed_holds_ = false;
  ++counts_.frames_nv12;
  const NativePart seen{as_const(image), {0, 0, buffer.width, buffer.height}};
  if (link_.preview) counts_.preview_bytes_copied += link_.preview->copy(seen, frame.flip);
  note_picture();
  return display_.present(frame.flip);
}

// A picture of the show is what stands from now on.
void FramePresenter::note_picture() noexcept {
  stands_ = true;
  black_ = another_show_ = false;
  pattern_ = nullptr;
  since_other_ = light_ < kWholeWeight ? 0 : std::min(since_other_ + 1, kOldest);
}

void FramePresenter::warp_into(const MutableImage& buffer, int age, const Frame& frame) noexcept {
  warp_begun_ = clock_.now();
  if (light_ < kWholeWeight || screenshot_) {
    dim_into(buffer, frame);
  } else {
    counts_.tiles += frame.show.warp(buffer, age <= since_other_ ? age : 0);
    undimmed_holds_ = false;
  }
  note_warp();
}

void FramePresenter::note_warp() noexcept {
  warp_done_ = clock_.now();
  warp_times_.add(warp_done_ - warp_begun_);
  counts_.warp.note(warp_done_ - warp_begun_);
}

void FramePresenter::dim_into(const MutableImage& buffer, const Frame& frame) noexcept {
  const bool changed = frame.change != Change::kUnchanged && frame.change != Change::kFailed;
  if (changed || !undimmed_holds_) {
    counts_.tiles += frame.show.warp(undimmed_.pixels(), undimmed_holds_ ? 1 : 0);
    undimmed_holds_ = true;
  }
  dim(as_const(undimmed_.pixels()), light_, buffer, frame.pool);
}

void FramePresenter::give_screenshot(const Frame& frame, std::int32_t light) noexcept {
  screenshot_->light = light;
  screenshot_->cue = frame.report.cue;
  screenshot_->position = frame.report.position;
  link_.screenshots->give_back(screenshot_);
  screenshot_ = nullptr;
  ++counts_.screenshots;
}

}  // namespace cupola
