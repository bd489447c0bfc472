// The decoders behind the stills, one a file format; not for use outside this folder and its tests.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>

#include "pipeline/frame/still.h"

namespace cupola {

// `file` begins with the format's signature. read_*: `into` has the probed size and `rows` lie within it and
// are not empty; the number of rows left undecoded is returned.
StillInfo probe_png(std::span<const std::byte> file, const std::string& name);
StillInfo probe_jpeg(std::span<const std::byte> file, const std::string& name);
StillInfo probe_tiff(std::span<const std::byte> file, const std::string& name);
StillInfo probe_exr(std::span<const std::byte> file, const std::string& name);
int read_png(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
             RowRange rows);
int read_jpeg(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
              RowRange rows);
int read_tiff(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
              RowRange rows);
int read_exr(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
             RowRange rows);

// Throws InputError when a side is 0 or larger than we take.
void check_size(const std::string& name, std::int64_t width, std::int64_t height);

// One row of `samples` (kRgb8 or kRgb16) into row `y`.
void store_row(const void* samples, PixelFormat format, const MutableImage& into, int y);

}  // namespace cupola
