// Small JPEG files, as a camera that compresses would send: flat grey blocks of 8 x 8 texels and a note.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cupola {

// Bytes that are enough for a picture of that size.
std::size_t jpeg_capacity(int width, int height);
// A baseline JPEG in grey: blocks get brighter by 8 from left to right and from one `phase` to the next.
// Allocates nothing. Returns its bytes.
std::size_t write_jpeg(std::span<std::uint8_t> memory, int width, int height, std::uint32_t phase,
                       std::uint64_t note);
// The note of a picture that write_jpeg() made, whole to its end; false for others.
bool read_jpeg_note(std::span<const std::uint8_t> jpeg, std::uint64_t& note);

}  // namespace cupola
