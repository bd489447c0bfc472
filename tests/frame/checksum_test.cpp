// The checksum sees every change of a byte, of the length and of the order.
// SPDX-License-Identifier: MIT
#include "pipeline/frame/checksum.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>
#include <vector>

namespace cupola {
namespace {

std::vector<std::byte> counting(std::size_t count) {
  std::vector<std::byte> bytes(count);
  for (std::size_t i = 0; i < count; ++i) bytes[i] = static_cast<std::byte>(i * 37 + i / 256);
  return bytes;
}

TEST(Checksum, ChangesWithEveryByte) {
  for (const std::size_t count : {1U, 7U, 8U, 63U, 64U, 65U, 200U}) {
    std::vector<std::byte> bytes = counting(count);
    std::set<std::uint64_t> sums{checksum(bytes)};
    for (std::byte& byte : bytes) {
      for (int bit = 0; bit < 8; ++bit) {
        byte ^= static_cast<std::byte>(1 << bit);
        EXPECT_TRUE(sums.insert(checksum(bytes)).second);
        byte ^= static_cast<std::byte>(1 << bit);
      }
    }
  }
}

TEST(Checksum, ChangesWithTheLengthOfZeros) {
  std::set<std::uint64_t> sums;
  for (std::size_t count = 0; count < 300; ++count) {
    EXPECT_TRUE(sums.insert(checksum(std::vector<std::byte>(count))).second) << count;
  }
}

TEST(Checksum, ChangesWithTheOrderAndTheSeed) {
  std::vector<std::byte> bytes = counting(640);
  const std::uint64_t before = checksum(bytes);
  EXPECT_NE(checksum(bytes, 1), before);
  std::swap_ranges(bytes.begin(), bytes.begin() + 64, bytes.begin() + 128);  // within the lanes
  EXPECT_NE(checksum(bytes), before);
  std::swap_ranges(bytes.begin(), bytes.begin() + 64, bytes.begin() + 128);
  std::swap_ranges(bytes.begin(), bytes.begin() + 8, bytes.begin() + 8);  // across them
  EXPECT_NE(checksum(bytes), before);
}

}  // namespace
}  // namespace cupola
