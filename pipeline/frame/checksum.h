// A checksum at the speed of memory, for finding damage, not malice.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>

namespace cupola {

// Eight lanes of 64 bits, each a chain of exclusive or, rotation and multiplication. Every step is one to
// one, so that damage within any eight bytes that begin at a multiple of eight always shows; other damage
// goes unseen once in 2^64. The bytes are read in the machine's order.
std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed = 0);

}  // namespace cupola
