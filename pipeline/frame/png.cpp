// PNG through libspng, in and out.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <spng.h>

#include <cstdlib>
#include <memory>
#include <string_view>
#include <vector>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still_formats.h"

namespace cupola {
namespace {

struct FreeContext {
  void operator()(spng_ctx* context) const { spng_ctx_free(context); }
};
using Context = std::unique_ptr<spng_ctx, FreeContext>;

std::uint32_t word_at(std::span<const std::byte> file, std::size_t offset) {
  std::uint32_t word = 0;
  for (std::size_t i = 0; i < 4; ++i) word = word << 8 | std::to_integer<std::uint32_t>(file[offset + i]);
  return word;
}

void check(int code, const std::string& name) {
  if (code == SPNG_OK) return;
  if (code == SPNG_IO_EOF || code == SPNG_EIDAT_TOO_SHORT || code == SPNG_EOF) {
    throw InputError(fmt::format("{}: the PNG is cut short", name));
  }
  if (code == SPNG_EMEM) throw std::bad_alloc();
  throw InputError(fmt::format("{}: the PNG is damaged: {}", name, spng_strerror(code)));
}

// Refuses what can be told without decoding: sizes, animation, and a file that does not reach its end.
void check_chunks(std::span<const std::byte> file, const std::string& name) {
  constexpr std::size_t kFirstChunk = 8;
  constexpr std::size_t kFrame = 12;  // length, type and checksum of a chunk
  constexpr std::uint32_t kEndChecksum = 0xae426082;
  for (std::size_t at = kFirstChunk; file.size() - at >= kFrame;) {
    const std::size_t length = word_at(file, at);
    const std::string_view type(reinterpret_cast<const char*>(file.data()) + at + 4, 4);
    if (type == "acTL")
      throw InputError(fmt::format("{}: is an animated PNG; expected a single picture", name));
    if (length > file.size() - at - kFrame) break;
    if (at == kFirstChunk && type == "IHDR" && length == 13) {
      check_size(name, word_at(file, at + 8), word_at(file, at + 12));
    }
    if (type == "IEND" && length == 0 && word_at(file, at + 8) == kEndChecksum) return;
    at += kFrame + length;
  }
  throw InputError(fmt::format("{}: the PNG is cut short", name));
}

Context open_png(std::span<const std::byte> file, const std::string& name, spng_ihdr& header) {
  check_chunks(file, name);
  Context context(spng_ctx_new(0));
  if (!context) throw std::bad_alloc();
  spng_set_image_limits(context.get(), kLargestSide, kLargestSide);
  // Texts and profiles are read by the library, although nobody asks for them.
  spng_set_chunk_limits(context.get(), std::size_t{16} << 20, std::size_t{32} << 20);
  check(spng_set_png_buffer(context.get(), file.data(), file.size()), name);
  check(spng_get_ihdr(context.get(), &header), name);
  return context;
}

// Deflate shrinks to no less than a 1032nd: a header that promises more lies.
void check_promise(std::span<const std::byte> file, const spng_ihdr& header, const std::string& name) {
  const int channels = header.color_type == SPNG_COLOR_TYPE_TRUECOLOR         ? 3
                       : header.color_type == SPNG_COLOR_TYPE_TRUECOLOR_ALPHA ? 4
                       : header.color_type == SPNG_COLOR_TYPE_GRAYSCALE_ALPHA ? 2
                                                                              : 1;
  const std::uint64_t bits = std::uint64_t{header.width} * header.height * header.bit_depth * channels;
  if (bits / 8 > (file.size() + 64) * std::uint64_t{1032}) {
    throw InputError(fmt::format("{}: the PNG is cut short", name));
  }
}

// RGBA to RGB in place.
void drop_alpha(std::uint16_t* samples, std::size_t pixels) {
  for (std::size_t x = 1; x < pixels; ++x)
    for (std::size_t c = 0; c < 3; ++c) samples[3 * x + c] = samples[4 * x + c];
}

}  // namespace

StillInfo probe_png(std::span<const std::byte> file, const std::string& name) {
  spng_ihdr header{};
  const Context context = open_png(file, name, header);
  return {{static_cast<int>(header.width), static_cast<int>(header.height)},
          header.bit_depth == 16 ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8};
}

int read_png(std::span<const std::byte> file, const std::string& name, const MutableImage& into,
             RowRange rows) {
  spng_ihdr header{};
  const Context context = open_png(file, name, header);
  check_promise(file, header, name);
  const bool deep = header.bit_depth == 16;
  const bool alpha = deep && header.color_type != SPNG_COLOR_TYPE_TRUECOLOR;
  const int wanted = alpha ? SPNG_FMT_RGBA16 : deep ? SPNG_FMT_PNG : SPNG_FMT_RGB8;
  const PixelFormat stored = deep ? PixelFormat::kRgb16 : PixelFormat::kRgb8;
  const int height = into.size.height;
  const std::size_t samples = static_cast<std::size_t>(into.size.width) * (alpha ? 4 : 3);
  const std::size_t row_bytes = samples * static_cast<std::size_t>(sample_bytes(stored));

  const auto store = [&](std::uint16_t* row, int y) {
    if (alpha) drop_alpha(row, static_cast<std::size_t>(into.size.width));
    store_row(row, stored, into, y);
  };
  if (header.interlace_method != SPNG_INTERLACE_NONE) {
    const std::size_t bytes = row_bytes * static_cast<std::size_t>(height);
    std::vector<std::uint16_t> all((bytes + 1) / 2);
    check(spng_decode_image(context.get(), all.data(), bytes, wanted, 0), name);
    check(spng_decode_chunks(context.get()), name);
    std::vector<std::uint16_t> row((row_bytes + 1) / 2);
    for (int y = rows.first; y < rows.last; ++y) {
      const auto* from =
          reinterpret_cast<const std::byte*>(all.data()) + static_cast<std::size_t>(y) * row_bytes;
      std::copy(from, from + row_bytes, reinterpret_cast<std::byte*>(row.data()));
      store(row.data(), y);
    }
    return 0;
  }
  std::vector<std::uint16_t> row((row_bytes + 1) / 2);
  check(spng_decode_image(context.get(), nullptr, 0, wanted, SPNG_DECODE_PROGRESSIVE), name);
  for (int y = 0; y < rows.last; ++y) {
    const int code = spng_decode_row(context.get(), row.data(), row_bytes);
    if (code != SPNG_EOI || y != height - 1) check(code, name);
    if (y >= rows.first) store(row.data(), y);
  }
  if (rows.last == height) check(spng_decode_chunks(context.get()), name);
  return height - rows.last;
}

void write_png(const std::filesystem::path& path, const Image& image) {
  const bool deep = sample_bytes(image.format) == 2;
  const PixelFormat stored = deep ? PixelFormat::kRgb16 : PixelFormat::kRgb8;
  AtomicFile file(path);

  const auto check_output = [&](int code) {
    if (code != SPNG_OK && code != SPNG_EOI) {
      throw Failure(fmt::format("{}: cannot be written: {}", path.string(), spng_strerror(code)));
    }
  };
  const Context context(spng_ctx_new(SPNG_CTX_ENCODER));
  if (!context) throw std::bad_alloc();
  spng_ihdr header{};
  header.width = static_cast<std::uint32_t>(image.size.width);
  header.height = static_cast<std::uint32_t>(image.size.height);
  header.bit_depth = deep ? 16 : 8;
  header.color_type = SPNG_COLOR_TYPE_TRUECOLOR;
  check_output(spng_set_option(context.get(), SPNG_ENCODE_TO_BUFFER, 1));
  check_output(spng_set_option(context.get(), SPNG_IMG_COMPRESSION_LEVEL, 1));
  check_output(spng_set_option(context.get(), SPNG_FILTER_CHOICE, SPNG_FILTER_CHOICE_AVG));
  check_output(spng_set_ihdr(context.get(), &header));
  check_output(spng_encode_image(context.get(), nullptr, 0, SPNG_FMT_PNG,
                                 SPNG_ENCODE_PROGRESSIVE | SPNG_ENCODE_FINALIZE));
  std::vector<std::uint16_t> row((static_cast<std::size_t>(image.size.width) * pixel_step(stored) + 1) / 2);
  for (int y = 0; y < image.size.height; ++y) {
    MutableImage to{stored, {image.size.width, 1}, {}};
    to.planes[0] = {reinterpret_cast<std::byte*>(row.data()), 0};
    convert(row_of(image, y), to);
    check_output(spng_encode_row(context.get(), row.data(),
                                 static_cast<std::size_t>(image.size.width) * pixel_step(stored)));
  }
  struct Free {
    void operator()(void* memory) const { std::free(memory); }
  };
  std::size_t length = 0;
  int code = SPNG_OK;
  const std::unique_ptr<void, Free> encoded(spng_get_png_buffer(context.get(), &length, &code));
  check_output(code);
  file.write(std::span(static_cast<const std::byte*>(encoded.get()), length));
  file.commit();
}

}  // namespace cupola
