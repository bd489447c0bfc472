// Fuzzes the readers of table files: any bytes are a table that can be executed, or none. The header is made
// right first, so that the fuzzer gets past it. Packed files are tried as they are.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <new>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_file.h"
#include "pipeline/warp/table_packing.h"
#include "tests/fuzz/table_seed.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cupola;
  static WorkerPool pool(1);
  static const Rig rig = table_fuzz_rig();
  static const test::Faces faces = test::make_faces(rig, test::noise(1, 65535), PixelFormat::kRgbPlanar16);
  static ImageBuffer frame(PixelFormat::kRgbPlanar16, rig.frame.size);
  static_cast<void>(unpack_table(std::as_bytes(std::span(data, size)), std::size_t{1} << 22, pool));
  // Of exactly its size on the heap, where the sanitizer sees every byte that is read beyond.
  const auto release = [](std::byte* memory) { ::operator delete (memory, std::align_val_t{64}); };
  const std::unique_ptr<std::byte, decltype(release)> memory(
      static_cast<std::byte*>(::operator new (size, std::align_val_t{64})), release);
  std::memcpy(memory.get(), data, size);
  const std::span<std::byte> file(memory.get(), size);
  correct_checksum(file, pool);
  // Deep faces: their sums have 64 bits, which no weights overflow.
  if (const auto table = read_table(file, rig, pool)) {
    make_table_warp(*table, Cpu::kScalar, pool)->warp(faces.images, frame.pixels());
  }
  return 0;
}
