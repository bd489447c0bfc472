// Baseline JPEG with DC coefficients only (ITU-T T.81): a quantiser of 8 makes one DC step one step of grey.
// SPDX-License-Identifier: MIT
#include "hal/camera/fake_jpeg.h"

#include <array>
#include <bit>
#include <cassert>
#include <cstring>

namespace cupola {

namespace {

constexpr std::array<std::uint8_t, 4> kBegin = {0xff, 0xd8, 0xff, 0xfe};  // SOI, COM
constexpr std::array<std::uint8_t, 6> kNoteName = {'c', 'u', 'p', 'o', 'l', 'a'};
constexpr int kCategories = 10;  // of DC differences, each with a code of 4 bits that is its number

class Writer {
 public:
  explicit Writer(std::span<std::uint8_t> memory) : memory_(memory) {}
  void byte(unsigned value) {
    assert(used_ < memory_.size());
    memory_[used_++] = static_cast<std::uint8_t>(value);
  }
  void word(unsigned value) {
    byte(value >> 8);
    byte(value);
  }
  template <std::size_t n>
  void bytes(const std::array<std::uint8_t, n>& values) {
    for (const std::uint8_t value : values) byte(value);
  }
  // At most 16 bits of entropy-coded data, the highest first; a byte of ones is followed by a zero.
  void bits(unsigned value, int count) {
    held_ = held_ << count | value;
    held_bits_ += count;
    while (held_bits_ >= 8) {
      held_bits_ -= 8;
      const unsigned next = held_ >> held_bits_ & 0xff;
      byte(next);
      if (next == 0xff) byte(0);
    }
  }
  void fill_last_byte() {
    if (held_bits_ > 0) bits((1U << (8 - held_bits_)) - 1, 8 - held_bits_);
  }
  std::size_t used() const { return used_; }

 private:
  std::span<std::uint8_t> memory_;
  std::size_t used_ = 0;
  unsigned held_ = 0;
  int held_bits_ = 0;
};

void write_tables(Writer& out, int width, int height) {
  out.word(0xffdb);  // quantiser
  out.word(2 + 1 + 64);
  out.byte(0);
  for (int i = 0; i < 64; ++i) out.byte(8);
  out.word(0xffc0);  // baseline, one component
  out.word(2 + 6 + 3);
  out.byte(8);
  out.word(static_cast<unsigned>(height));
  out.word(static_cast<unsigned>(width));
  out.bytes(std::array<std::uint8_t, 4>{1, 1, 0x11, 0});
  out.word(0xffc4);  // codes of DC differences' categories: 4 bits each
  out.word(2 + 1 + 16 + kCategories);
  out.byte(0x00);
  for (int length = 1; length <= 16; ++length) out.byte(length == 4 ? kCategories : 0);
  for (unsigned category = 0; category < kCategories; ++category) out.byte(category);
  out.word(0xffc4);  // of AC coefficients there is one code, "no more in this block": one bit, 0
  out.word(2 + 1 + 16 + 1);
  out.byte(0x10);
  for (int length = 1; length <= 16; ++length) out.byte(length == 1 ? 1 : 0);
  out.byte(0x00);
  out.word(0xffda);  // scan
  out.word(2 + 1 + 2 + 3);
  out.bytes(std::array<std::uint8_t, 6>{1, 1, 0x00, 0, 63, 0});
}

// |difference| is below 256: at most 8 bits behind the category's 4.
void write_block(Writer& out, int difference) {
  const auto size = static_cast<unsigned>(difference < 0 ? -difference : difference);
  const int category = std::bit_width(size);
  out.bits(static_cast<unsigned>(category), 4);
  if (category > 0) {
    out.bits(difference > 0 ? size : ~size & ((1U << category) - 1), category);
  }
  out.bits(0, 1);
}

std::size_t blocks(int width, int height) {
  return static_cast<std::size_t>((width + 7) / 8) * static_cast<std::size_t>((height + 7) / 8);
}

}  // namespace

std::size_t jpeg_capacity(int width, int height) {
  return 256 +
         4 * blocks(width, height);  // 13 bits a block at most, doubled by the zeros after bytes of ones
}

std::size_t write_jpeg(std::span<std::uint8_t> memory, int width, int height, std::uint32_t phase,
                       std::uint64_t note) {
  Writer out(memory);
  out.bytes(kBegin);
  out.word(2 + kNoteName.size() + 8);
  out.bytes(kNoteName);
  for (int shift = 56; shift >= 0; shift -= 8) out.byte(static_cast<unsigned>(note >> shift & 0xff));
  write_tables(out, width, height);
  int before = 0;
  for (int y = 0; y < height; y += 8) {
    for (int x = 0; x < width; x += 8) {
      const int grey = static_cast<int>((static_cast<std::uint32_t>(x) + 8 * phase) % 256) - 128;
      write_block(out, grey - before);
      before = grey;
    }
  }
  out.fill_last_byte();
  out.word(0xffd9);
  return out.used();
}

bool read_jpeg_note(std::span<const std::uint8_t> jpeg, std::uint64_t& note) {
  constexpr std::size_t kName = kBegin.size() + 2;
  constexpr std::size_t kNote = kName + kNoteName.size();
  if (jpeg.size() < kNote + 8 + 2) return false;
  if (std::memcmp(jpeg.data(), kBegin.data(), kBegin.size()) != 0) return false;
  if (std::memcmp(jpeg.data() + kName, kNoteName.data(), kNoteName.size()) != 0) return false;
  if (jpeg[jpeg.size() - 2] != 0xff || jpeg[jpeg.size() - 1] != 0xd9) return false;
  note = 0;
  for (std::size_t i = 0; i < 8; ++i) note = note << 8 | jpeg[kNote + i];
  return true;
}

}  // namespace cupola
