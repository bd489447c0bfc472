// Still pictures in files: PNG, JPEG, TIFF and EXR, told apart by their first bytes, never by their names.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>

#include "pipeline/frame/file_bytes.h"
#include "pipeline/frame/image.h"
#include "pipeline/frame/row_range.h"

namespace cupola {

// Alpha is dropped, grey and palettes become RGB. Ignored: gamma, sRGB and ICC profiles, and the orientation
// that EXIF or TIFF may ask for: row 0 is the first one stored. Refused: animated PNG, CMYK and YCCK JPEG,
// EXR with several parts, deep pixels or whole numbers, and TIFF with several pages, tiles, separate planes,
// CMYK, or samples that are no unsigned integers of up to 16 bits. EXR is linear light and becomes 16 bits of
// sRGB (0 to 1 of it; what is no number is 0); its picture is the display window, black where it has no data.
// Every function that reads throws InputError: file, what is wrong, what was expected.

inline constexpr int kLargestSide = 32'768;
inline constexpr std::int64_t kMostPixels = std::int64_t{1} << 29;  // checked before anything is allocated

struct StillInfo {
  Size size;
  PixelFormat format = PixelFormat::kRgbPlanar8;  // kRgbPlanar16 when the file has 16 bits a sample
};

// From the header only; the picture may yet turn out to be damaged.
StillInfo probe_still(const std::filesystem::path& path);
StillInfo probe_still(std::span<const std::byte> file, const std::string& name);

// The picture in the format that the probe gives.
ImageBuffer read_still(const std::filesystem::path& path);

// Fills the rows of `rows`; other rows hold anything afterwards, and those below are not decoded (damage
// there goes unnoticed). `into` is planar, of the file's size, of 8 or 16 bits whatever the file has. When it
// throws, `into` may be partly written. Returns how many rows were left undecoded.
int decode_still(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
                 RowRange rows = {});
// The same from a file; `memory` holds it meanwhile and is used again from call to call.
int read_still_into(const std::filesystem::path& path, const MutableImage& into, RowRange rows,
                    FileBytes& memory);

// 8 or 16 bits a sample as `image` has, in any of our formats; lightly compressed, for speed. Throws Failure
// and leaves no partial file.
void write_png(const std::filesystem::path& path, const Image& image);
// Linear light in half floats, channels R, G and B, ZIP: the samples' sRGB decoded. Light has 11 significant
// bits there: 16-bit codes come back within 10 steps, those of 8 bits exactly. Throws Failure as above;
// InputError in builds without OpenEXR.
void write_exr(const std::filesystem::path& path, const Image& image);

enum class StillFormat { kPng, kExr };
void write_still(const std::filesystem::path& path, const Image& image, StillFormat format);

}  // namespace cupola
