// Pictures that tell which camera made them and when: a grey slope that moves with the sequence, and in its
// first row the camera's number and the sequence as dark and bright texels.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/camera/camera.h"

namespace cupola {

struct PictureStamp {
  int camera = 0;              // 0 to 255
  std::uint32_t sequence = 0;  // modulo 2^32
  friend bool operator==(const PictureStamp&, const PictureStamp&) = default;
};

// What a picture says of itself; none where it is too narrow or is no such picture.
std::optional<PictureStamp> read_stamp(const CameraFrame& frame);

class FakePicture {
 public:
  static constexpr int kLeastWidth = 40;  // texels

  // Throws std::runtime_error for sides that are too small, or above 65535.
  FakePicture(CameraFormat format, int width, int height, int camera);

  // Bytes of a picture with rows of no more than their texels; of kMjpeg, what is enough.
  std::size_t bytes() const { return bytes_; }
  // Once for each piece of memory, before draw(): the parts that never change. Planes lie behind each other.
  void prepare(std::span<std::uint8_t> memory) const;
  // Allocates nothing. Returns the bytes used.
  std::size_t draw(std::span<std::uint8_t> memory, std::uint32_t sequence) const;
  // Points the frame's format, size and planes at a picture drawn in `memory`.
  void describe(const std::uint8_t* memory, std::size_t used, CameraFrame& frame) const;

 private:
  CameraFormat format_;
  int width_;
  int height_;
  int camera_;
  std::size_t bytes_ = 0;
  std::size_t row_bytes_ = 0;        // of the first plane
  std::size_t texel_bytes_ = 0;      // of the first plane
  std::vector<std::uint8_t> slope_;  // a row and a slope's length more: rows are copied from anywhere in it
};

}  // namespace cupola
