// Copies of the faces, each changed in its own way.
// SPDX-License-Identifier: MIT
#include "firmware/bench_skipping.h"

#include <algorithm>

#include "pipeline/source/face_changes.h"
#include "pipeline/warp/ewa_warp.h"

namespace cupola {
namespace {

std::vector<ImageBuffer> copies(std::span<const Image> faces) {
  std::vector<ImageBuffer> buffers;
  for (const Image& face : faces) {
    buffers.emplace_back(face.format, face.size);
    convert(face, buffers.back().pixels());
  }
  return buffers;
}

std::vector<Image> images_of(const std::vector<ImageBuffer>& buffers) {
  std::vector<Image> images;
  for (const ImageBuffer& buffer : buffers) images.push_back(buffer.pixels());
  return images;
}

// Inverts the square of `side` texels about the middle.
void invert(ImageBuffer& face, int side) {
  const Size size = face.size();
  for (int plane = 0; plane < 3; ++plane) {
    for (int y = (size.height - side) / 2; y < (size.height + side) / 2; ++y) {
      auto* row = face.pixels().samples<std::uint8_t>(plane, y);
      for (int x = (size.width - side) / 2; x < (size.width + side) / 2; ++x) row[x] ^= 255;
    }
  }
}

std::int64_t bright_pixels(const Image& frame) {
  std::int64_t count = 0;
  for (int y = 0; y < frame.size.height; ++y) {
    const auto* row = frame.samples<std::uint8_t>(0, y);
    for (int x = 0; x < frame.size.width; ++x) count += row[x] >> 7;
  }
  return count;
}

}  // namespace

SkippingBench::SkippingBench(const Rig& rig, const WarpTable& table, std::span<const Image> faces,
                             std::int64_t in_image, WorkerPool& alone)
    : faces_(faces),
      in_image_(static_cast<double>(in_image)),
      warp_(make_table_warp(table, best_cpu(), alone)),
      frame_(PixelFormat::kRgbPlanar8, rig.frame.size),
      same_(copies(faces)),
      moved_(copies(faces)),
      other_(copies(faces)) {
  for (std::size_t i = 0; i < faces.size(); ++i) {
    black_.emplace_back(faces[i].format, faces[i].size);
    none_.emplace_back(faces[i].size);
    uneven_.emplace_back(faces[i].size);
    for (int y = 0; y < faces[i].size.height; ++y) {
      for (const auto& plane : other_[i].pixels().planes) {
        for (int x = 0; x < faces[i].size.width; ++x) plane.row(y)[x] ^= std::byte{1};
      }
    }
  }
  black_images_ = images_of(black_);
  some_ = scratch_ = none_;
  even_ = scratch_even_ = uneven_;
  for (std::size_t i = 0; i < faces.size(); ++i) {
    even_[i].look(black_images_[i], warp_->needed()[i], nullptr);
    uneven_[i].look(faces_[i], warp_->needed()[i], nullptr);
  }
  change(0.05);
}

void SkippingBench::change(double share) {
  int least = 0;
  int most = std::min(faces_[0].size.width, faces_[0].size.height);
  while (most - least > 1) {
    const int side = (least + most) / 2;
    invert(black_[0], side);
    warp_->warp(black_images_, frame_.pixels());
    invert(black_[0], side);
    (static_cast<double>(bright_pixels(as_const(frame_.pixels()))) < share * in_image_ ? least : most) = side;
  }
  invert(moved_[0], most);
  moved_images_ = images_of(moved_);
  compare(moved_, some_, false);
}

void SkippingBench::compare(const std::vector<ImageBuffer>& with, Changes& changed, bool look_for_even) {
  for (std::size_t i = 0; i < faces_.size(); ++i) {
    changed[i].clear();
    add_changes(faces_[i], with[i].pixels(), warp_->needed()[i], changed[i]);
    if (look_for_even) scratch_even_[i].look(with[i].pixels(), warp_->needed()[i], &changed[i]);
  }
}

std::vector<Lap> SkippingBench::laps() {
  std::vector<Lap> laps;
  const auto add = [&](const char* name, std::function<void()> work) {
    laps.push_back({{name, 0, 0, 0, -1, -1}, std::move(work), {}});
  };
  add("ewa fast, unchanged", [&] { warp_->warp_known(faces_, {none_, uneven_}, frame_.pixels()); });
  add("ewa fast, 5 % of the picture changed", [&] {
    warp_->warp_known(moved_images_, {some_, uneven_}, frame_.pixels());
  });
  add("ewa fast, black faces", [&] { warp_->warp_known(black_images_, {{}, even_}, frame_.pixels()); });
  add("comparing faces, unchanged", [&] { compare(same_, scratch_, true); });
  add("comparing faces, 5 % of the picture changed", [&] { compare(moved_, scratch_, true); });
  add("comparing faces, all changed", [&] { compare(other_, scratch_, true); });
  add("comparing faces, all changed to black", [&] { compare(black_, scratch_, true); });
  return laps;
}

}  // namespace cupola
