// Multiplications, the slowest step, are two for eight bytes; eight lanes keep the multiplier busy.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/checksum.h"

#include <array>
#include <bit>
#include <cstring>

namespace cupola {
namespace {

constexpr std::size_t kLanes = 8;
constexpr std::size_t kStripe = kLanes * sizeof(std::uint64_t);
// Odd, so that multiplication can be undone: 2^64 by the golden ratio and by pi.
constexpr std::uint64_t kFactor = 0x9e3779b97f4a7c15;
constexpr std::uint64_t kSpread = 0x517cc1b727220a95;

// The word is multiplied too: otherwise its top bit would stay one bit, which one bit of the next word
// undoes.
std::uint64_t mix(std::uint64_t state, std::uint64_t word) {
  return std::rotl(state ^ (word * kSpread), 29) * kFactor;
}

}  // namespace

std::uint64_t checksum(std::span<const std::byte> bytes, std::uint64_t seed) {
  std::array<std::uint64_t, kLanes> lane;
  for (std::size_t i = 0; i < kLanes; ++i) lane[i] = seed + i * kFactor;
  std::array<std::uint64_t, kLanes> words;
  const std::byte* at = bytes.data();
  std::size_t left = bytes.size();
  for (; left >= kStripe; left -= kStripe, at += kStripe) {
    std::memcpy(words.data(), at, kStripe);
    for (std::size_t i = 0; i < kLanes; ++i) lane[i] = mix(lane[i], words[i]);
  }
  words.fill(0);
  if (left > 0) std::memcpy(words.data(), at, left);
  std::uint64_t sum = mix(seed, bytes.size());
  for (std::size_t i = 0; i < kLanes; ++i) sum = mix(sum, mix(lane[i], words[i]));
  sum = (sum ^ (sum >> 32)) * kFactor;
  return sum ^ (sum >> 29);
}

}  // namespace cupola
