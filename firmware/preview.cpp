// Rows by the nearest pixel; whole previews change places with the one that is shown.
// SPDX-License-Identifier: MIT
#include "firmware/preview.h"

#include <algorithm>
#include <cstring>
#include <utility>

namespace cupola {
namespace {

Size scaled(Size frame) {
  const int longer = std::max(frame.width, frame.height);
  if (longer <= Preview::kLargestSide) return frame;
  const auto side = [&](int of) { return std::max(1, of * Preview::kLargestSide / longer); };
  return {side(frame.width), side(frame.height)};
}

}  // namespace

Preview::Preview(Size frame)
    : frame_(frame),
      making_(PixelFormat::kXrgb8888, scaled(frame)),
      ready_(PixelFormat::kXrgb8888, scaled(frame)) {}

bool Preview::wants(std::chrono::nanoseconds flip) noexcept {
  if (whole_) finish(flip);
  if (!busy_ && !whole_ && flip >= not_before_ && asked_.exchange(false, std::memory_order_relaxed)) {
    busy_ = true;
    part_ = 0;
    not_before_ = flip + kEvery;
  }
  return busy_;
}

std::int64_t Preview::copy(const Image& frame, std::chrono::nanoseconds flip) noexcept {
  if (!busy_ || frame.size != frame_) return 0;
  const Size size = making_.size();
  const int first = size.height * part_ / kParts;
  const int last = size.height * (part_ + 1) / kParts;
  for (int y = first; y < last; ++y) {
    const auto* from = frame.samples<std::uint32_t>(0, (2 * y + 1) * frame_.height / (2 * size.height));
    auto* to = making_.pixels().samples<std::uint32_t>(0, y);
    for (int x = 0; x < size.width; ++x) to[x] = from[(2 * x + 1) * frame_.width / (2 * size.width)];
  }
  if (++part_ == kParts) {
    busy_ = false;
    whole_ = true;
    finish(flip);
  }
  return std::int64_t{4} * size.width * (last - first);
}

std::int64_t Preview::copy_black(std::chrono::nanoseconds flip) noexcept {
  if (!busy_) return 0;
  const Size size = making_.size();
  for (int y = 0; y < size.height; ++y) {
    std::fill_n(making_.pixels().samples<std::uint32_t>(0, y), size.width, 0xff000000U);
  }
  busy_ = false;
  whole_ = true;
  finish(flip);
  return std::int64_t{4} * size.width * size.height;
}

// Where somebody reads the other one just now: at the next frame.
void Preview::finish(std::chrono::nanoseconds flip) noexcept {
  if (!mutex_.try_lock()) return;
  std::swap(making_, ready_);
  ++number_;
  made_at_ = flip;
  mutex_.unlock();
  whole_ = false;
}

std::int64_t Preview::newest(ImageBuffer& into) {
  asked_.store(true, std::memory_order_relaxed);
  const std::lock_guard lock(mutex_);
  if (number_ == 0) return 0;
  if (into.empty() || into.size() != ready_.size()) into = ImageBuffer(PixelFormat::kXrgb8888, ready_.size());
  for (int y = 0; y < ready_.size().height; ++y) {
    std::memcpy(into.pixels().planes[0].row(y), ready_.pixels().planes[0].row(y),
                std::size_t{4} * static_cast<std::size_t>(ready_.size().width));
  }
  return number_;
}

std::chrono::nanoseconds Preview::made_at() const {
  const std::lock_guard lock(mutex_);
  return made_at_;
}

}  // namespace cupola
