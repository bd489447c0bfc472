// Rows by the nearest pixel; whole previews change places with the one that is shown.
// SPDX-License-Identifier: MIT
#include "firmware/preview.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <utility>

namespace cupola {
namespace {

constexpr std::uint32_t kBlack = 0xff000000U;

Size scaled(Size picture, int longest) {
  const int longer = std::max(picture.width, picture.height);
  if (longer <= longest) return picture;
  const auto side = [&](int of) { return std::max(1, of * longest / longer); };
  return {side(picture.width), side(picture.height)};
}

std::uint32_t packed(std::uint32_t red, std::uint32_t green, std::uint32_t blue) {
  return kBlack | red << 16 | green << 8 | blue;
}

// Row `y` as words 0xffRRGGBB by columns.
auto xrgb_row(const Image& image, int y) {
  return [row = image.samples<std::uint32_t>(0, y)](int x) { return kBlack | row[x]; };
}

// The same of any other format, by the upper eight bits of its samples.
auto rgb_row(const Image& image, int y) {
  const int bytes = sample_bytes(image.format);
  std::array<const std::byte*, 3> rows{};  // the upper byte of each channel's first sample
  for (int c = 0; c < 3; ++c) {
    const bool planar = plane_count(image.format) == 3;
    rows[static_cast<std::size_t>(c)] =
        image.planes[planar ? static_cast<std::size_t>(c) : 0].row(y) + (planar ? 0 : c * bytes) + bytes - 1;
  }
  return [rows, step = pixel_step(image.format)](int x) {
    const auto value = [&](std::size_t c) {
      return std::to_integer<std::uint32_t>(rows[c][std::ptrdiff_t{x} * step]);
    };
    return packed(value(0), value(1), value(2));
  };
}

auto native_row(const NativePart& part, int y) {
  return [&part, y](int x) {
    const NativeImage& picture = part.picture;
    const TexelBox& there = part.there;
    if (x < there.x0 || x >= there.x1 || y < there.y0 || y >= there.y1) return kBlack;
    if (is_rgb(picture.layout)) {
      return packed(*sample_at(picture, 0, x, y), *sample_at(picture, 1, x, y), *sample_at(picture, 2, x, y));
    }
    const int chroma_y = has_chroma_in_every_row(picture.layout) ? y : y / 2;
    const auto rgb = rgb_of(picture.colour, *sample_at(picture, 0, x, y),
                            *sample_at(picture, 1, x / 2, chroma_y), *sample_at(picture, 2, x / 2, chroma_y));
    const auto rounded = [](double value) {
      return static_cast<std::uint32_t>(std::lround(std::clamp(value, 0.0, 255.0)));
    };
    return packed(rounded(rgb[0]), rounded(rgb[1]), rounded(rgb[2]));
  };
}

}  // namespace

Preview::Preview(Size picture, int longest) : picture_(picture), longest_(longest) {
  const Size size = scaled(picture, longest);
  for (Small* small : {&making_, &ready_}) *small = {ImageBuffer(PixelFormat::kXrgb8888, size), size};
}

bool Preview::wants(std::chrono::nanoseconds flip) noexcept {
  if (whole_) finish(flip);
  if (!busy_ && !whole_ && flip >= not_before_ && asked_.exchange(false, std::memory_order_relaxed)) {
    busy_ = true;
    part_ = 0;
    not_before_ = flip + kEvery;
  }
  return busy_;
}

std::int64_t Preview::copy(const FacePicture& picture, std::chrono::nanoseconds flip) noexcept {
  if (const auto* image = std::get_if<Image>(&picture)) {
    if (image->format == PixelFormat::kXrgb8888) {
      return copy_rows(
          image->size, [&](int y) { return xrgb_row(*image, y); }, flip);
    }
    return copy_rows(
        image->size, [&](int y) { return rgb_row(*image, y); }, flip);
  }
  if (const auto* part = std::get_if<NativePart>(&picture)) {
    return copy_rows(
        part->picture.size, [&](int y) { return native_row(*part, y); }, flip);
  }
  return copy_black(flip);
}

template <class RowOf>
std::int64_t Preview::copy_rows(Size from, RowOf row_of, std::chrono::nanoseconds flip) noexcept {
  const Size largest = making_.buffer.size();
  const Size size = scaled(from, longest_);
  if (!busy_ || size.width > largest.width || size.height > largest.height) return 0;
  if (from != picture_) part_ = 0;
  picture_ = from;
  making_.size = size;
  const MutableImage pixels = making_.pixels();
  const int first = size.height * part_ / kParts;
  const int last = size.height * (part_ + 1) / kParts;
  for (int y = first; y < last; ++y) {
    const auto row = row_of((2 * y + 1) * from.height / (2 * size.height));
    auto* to = pixels.samples<std::uint32_t>(0, y);
    for (int x = 0; x < size.width; ++x) to[x] = row((2 * x + 1) * from.width / (2 * size.width));
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
  const MutableImage pixels = making_.pixels();
  for (int y = 0; y < pixels.size.height; ++y) {
    std::fill_n(pixels.samples<std::uint32_t>(0, y), pixels.size.width, kBlack);
  }
  busy_ = false;
  whole_ = true;
  finish(flip);
  return std::int64_t{4} * pixels.size.width * pixels.size.height;
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
  const Size size = ready_.size;
  if (into.empty() || into.size() != size) into = ImageBuffer(PixelFormat::kXrgb8888, size);
  for (int y = 0; y < size.height; ++y) {
    std::memcpy(into.pixels().planes[0].row(y), ready_.pixels().planes[0].row(y),
                std::size_t{4} * static_cast<std::size_t>(size.width));
  }
  return number_;
}

std::chrono::nanoseconds Preview::made_at() const {
  const std::lock_guard lock(mutex_);
  return made_at_;
}

}  // namespace cupola
