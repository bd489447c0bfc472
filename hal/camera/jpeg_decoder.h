// A camera's JPEG pictures into planes of Y, U and V as they were compressed, through libjpeg-turbo.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstdint>
#include <memory>
#include <optional>
#include <span>

#include "hal/camera/camera.h"

namespace cupola {

struct JpegKind {
  CameraFormat format = CameraFormat::kI420;  // or kI422, kGrey
  int width = 0;                              // texels
  int height = 0;
  friend bool operator==(const JpegKind&, const JpegKind&) = default;
};

// libjpeg writes whole blocks: rows and columns up to the next multiple of 16 must have room in every plane
// of luma, of 8 in those of chroma.
constexpr int jpeg_room(int side) {
  return (side + 15) / 16 * 16;
}

struct JpegPlane {
  std::uint8_t* data = nullptr;
  std::ptrdiff_t stride = 0;
};

// One thread. Huffman tables may be missing, as UVC cameras leave them out.
class JpegDecoder {
 public:
  // Throws std::bad_alloc.
  JpegDecoder();
  ~JpegDecoder();
  JpegDecoder(const JpegDecoder&) = delete;
  JpegDecoder& operator=(const JpegDecoder&) = delete;

  // From the header alone. None: it is damaged, or no baseline picture of a kind that JpegKind has.
  std::optional<JpegKind> look(std::span<const std::uint8_t> jpeg) noexcept;

  enum class Outcome : std::uint8_t {
    kDone,
    kDamaged,  // planes may hold part of it
    kOther,    // it is not of `kind`; planes are untouched
  };
  // At least the first `rows` rows, which spares the work for the others. The library allocates.
  Outcome decode(std::span<const std::uint8_t> jpeg, const JpegKind& kind,
                 const std::array<JpegPlane, 3>& planes, int rows) noexcept;

 private:
  struct Library;
  std::unique_ptr<Library> library_;
};

}  // namespace cupola
