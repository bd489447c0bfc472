// Frames of a fixed number of bytes, each with its length in front and its checksum behind.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_packing.h"

#include <zstd.h>

#include <algorithm>
#include <atomic>
#include <memory>
#include <new>
#include <stdexcept>

namespace cupola {
namespace {

// From 3 to 12 the files lose a tenth and packing takes five times as long.
constexpr int kLevel = 3;

struct Frame {
  std::span<const std::byte> packed;
  std::size_t at;  // in the table file
  std::size_t bytes;
};

// Nothing where they are not frames of kPackedPart bytes, the last one of fewer.
std::optional<std::vector<Frame>> find_frames(std::span<const std::byte> packed, std::size_t most_bytes) {
  std::vector<Frame> frames;
  std::size_t at = 0;
  while (!packed.empty()) {
    if (at % kPackedPart != 0) return std::nullopt;
    const std::size_t length = ZSTD_findFrameCompressedSize(packed.data(), packed.size());
    if (ZSTD_isError(length)) return std::nullopt;
    const unsigned long long bytes = ZSTD_getFrameContentSize(packed.data(), packed.size());
    if (bytes == 0 || bytes > kPackedPart || bytes > most_bytes - at) return std::nullopt;  // unknown: huge
    frames.push_back({packed.first(length), at, static_cast<std::size_t>(bytes)});
    at += static_cast<std::size_t>(bytes);
    packed = packed.subspan(length);
  }
  if (frames.empty()) return std::nullopt;
  return frames;
}

}  // namespace

std::vector<std::byte> pack_table(std::span<const std::byte> file, WorkerPool& pool) {
  std::vector<std::vector<std::byte>> frames((file.size() + kPackedPart - 1) / kPackedPart);
  pool.run(static_cast<int>(frames.size()), [&](int i) {
    const auto rest = file.subspan(static_cast<std::size_t>(i) * kPackedPart);
    const auto part = rest.first(std::min(rest.size(), kPackedPart));
    std::vector<std::byte>& frame = frames[static_cast<std::size_t>(i)];
    frame.resize(ZSTD_compressBound(part.size()));
    const std::unique_ptr<ZSTD_CCtx, decltype(&ZSTD_freeCCtx)> context(ZSTD_createCCtx(), &ZSTD_freeCCtx);
    if (!context) throw std::bad_alloc();
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_compressionLevel, kLevel);
    ZSTD_CCtx_setParameter(context.get(), ZSTD_c_checksumFlag, 1);
    const std::size_t length =
        ZSTD_compress2(context.get(), frame.data(), frame.size(), part.data(), part.size());
    if (ZSTD_isError(length)) throw std::logic_error(ZSTD_getErrorName(length));
    frame.resize(length);
  });
  std::vector<std::byte> packed;
  for (const std::vector<std::byte>& frame : frames) packed.insert(packed.end(), frame.begin(), frame.end());
  return packed;
}

std::optional<MappedBytes> unpack_table(std::span<const std::byte> packed, std::size_t most_bytes,
                                        WorkerPool& pool) {
  const auto frames = find_frames(packed, most_bytes);
  if (!frames) return std::nullopt;
  MappedBytes memory = MappedBytes::zeros(frames->back().at + frames->back().bytes);
  const std::span<std::byte> file = memory.writable();
  std::atomic<bool> whole{true};
  pool.run(static_cast<int>(frames->size()), [&](int i) {
    const Frame& frame = (*frames)[static_cast<std::size_t>(i)];
    const std::size_t bytes =
        ZSTD_decompress(file.data() + frame.at, frame.bytes, frame.packed.data(), frame.packed.size());
    if (bytes != frame.bytes) whole = false;  // an error is a very large number
  });
  if (!whole) return std::nullopt;
  return memory;
}

}  // namespace cupola
