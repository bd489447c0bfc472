// Every instruction set's tile kernel and row store against the scalar ones, one by one: random tables, the
// worst texels, all reflections and strides, and memory that must not be touched.
//
// With CUPOLA_TIME_KERNELS in the environment the kernels are timed too, on what was just checked.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <sys/mman.h>
#include <unistd.h>

#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <optional>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/row_store.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/tile_kernel.h"
#include "tests/warp/faces.h"
#include "tests/warp/random_table.h"

namespace cupola {
namespace {

using test::between;
using test::Random;

// Memory between two pages that nobody may touch; what is asked for touches one of them.
class GuardedBytes {
 public:
  GuardedBytes(std::size_t size, bool at_end) {
    const auto page = static_cast<std::size_t>(sysconf(_SC_PAGESIZE));
    const std::size_t inside = (size + page - 1) / page * page;
    mapped_ = inside + 2 * page;
    start_ =
        static_cast<std::uint8_t*>(mmap(nullptr, mapped_, PROT_NONE, MAP_PRIVATE | MAP_ANONYMOUS, -1, 0));
    if (start_ == MAP_FAILED || mprotect(start_ + page, inside, PROT_READ | PROT_WRITE) != 0) std::abort();
    bytes_ = start_ + page + (at_end ? inside - size : 0);
  }
  ~GuardedBytes() { munmap(start_, mapped_); }
  GuardedBytes(const GuardedBytes&) = delete;
  GuardedBytes& operator=(const GuardedBytes&) = delete;

  std::uint8_t* bytes() { return bytes_; }

 private:
  std::uint8_t* start_;
  std::size_t mapped_;
  std::uint8_t* bytes_;
};

// A view's three planes of texels of `step` bytes, each ending (or beginning) where memory does.
class GuardedView {
 public:
  GuardedView(Random& random, Size size, int step) : size_(size), step_(step) {
    const bool at_end = between(random, 0, 1) == 0;
    stride_ = static_cast<std::size_t>((size.width + between(random, 0, 70)) * step);
    bytes_ =
        stride_ * static_cast<std::size_t>(size.height - 1) + static_cast<std::size_t>(size.width * step);
    for (auto& plane : planes_) plane = std::make_unique<GuardedBytes>(bytes_, at_end);
  }

  void fill(Random& random, int pattern) {
    for (std::size_t channel = 0; channel < 3; ++channel) {
      for (std::size_t i = 0; i < bytes_; ++i) {
        const int texel = pattern == 0   ? between(random, 0, 255)
                          : pattern == 1 ? between(random, 0, 1) * 255
                          : pattern == 2 ? 0
                                         : 255;
        planes_[channel]->bytes()[i] = static_cast<std::uint8_t>(texel);
      }
    }
  }

  // Channels begin in planes of their own, or `apart` bytes from each other in the first one.
  ViewTexels mirrored(bool flip_u, bool flip_v, std::optional<std::array<std::ptrdiff_t, 3>> apart) const {
    ViewTexels texels;
    texels.step = step_;
    texels.across = flip_u ? -step_ : step_;
    texels.flip = flip_u ? 0x07070707 : 0;
    const auto stride = static_cast<std::ptrdiff_t>(stride_);
    texels.origin = planes_[0]->bytes() + (flip_v ? (size_.height - 1) * stride : 0) +
                    (flip_u ? size_.width - kWindowSide : 0) * step_;
    texels.stride = flip_v ? -stride : stride;
    for (std::size_t channel = 0; channel < 3; ++channel) {
      texels.channel[channel] = ViewTexels::bytes_between(planes_[0]->bytes(), planes_[channel]->bytes());
    }
    if (apart) texels.channel = *apart;
    return texels;
  }

 private:
  Size size_;
  int step_;
  std::size_t stride_ = 0;
  std::size_t bytes_ = 0;
  std::array<std::unique_ptr<GuardedBytes>, 3> planes_;
};

// How texels lie in memory: bytes from one to the next, and where channels begin unless in their own planes.
struct Layout {
  int step = 1;
  std::optional<std::array<std::ptrdiff_t, 3>> apart = std::nullopt;
};

// Four reflections of a tile, each in pixels of its own.
template <class Pixel>
class TilePictures {
 public:
  TilePictures(Random& random, const std::vector<std::unique_ptr<GuardedView>>& views, const Layout& layout)
      : stride_(kTileWidth + between(random, 0, 9)) {
    for (std::size_t i = 0; i < 4; ++i) {
      for (const auto& view : views) {
        views_[i].push_back(
            view->mirrored(between(random, 0, 1) != 0, between(random, 0, 1) != 0, layout.apart));
      }
    }
  }

  // As bytes.
  std::vector<std::uint8_t> made_by(TileKernel<Pixel> kernel, const WarpTable& table,
                                    const Tile& tile) const {
    const auto picture = static_cast<std::size_t>(stride_ * kTileHeight);
    std::vector<Pixel> pixels(4 * picture);
    std::memset(static_cast<void*>(pixels.data()), 0xa5, pixels.size() * sizeof(Pixel));
    std::array<TileImage<Pixel>, 4> images;
    for (std::size_t i = 0; i < 4; ++i) {
      const bool across = i % 2 == 1;
      images[i] = {views_[i], pixels.data() + i * picture + (across ? kTileWidth - 1 : 0), stride_, across};
    }
    kernel(table, tile, images);
    const auto* bytes = reinterpret_cast<const std::uint8_t*>(pixels.data());
    return {bytes, bytes + pixels.size() * sizeof(Pixel)};
  }

 private:
  std::ptrdiff_t stride_;
  std::array<std::vector<ViewTexels>, 4> views_;
};

class EveryKernel : public testing::TestWithParam<Cpu> {
 protected:
  void SetUp() override {
    if (!supported(GetParam())) GTEST_SKIP() << "this machine has no " << name(GetParam());
  }

  static void expect_scalar_bits(std::span<const BlockKind> kinds, unsigned seed) {
    expect_same_bits<Xrgb>(kinds, seed, {}, run_tile_scalar, tile_kernel(GetParam()));
  }

  template <class Pixel>
  static void expect_same_bits(std::span<const BlockKind> kinds, unsigned seed, const Layout& layout,
                               TileKernel<Pixel> scalar, TileKernel<Pixel> kernel, int tables = 12) {
    Random random(seed);
    for (int i = 0; i < tables; ++i) {
      std::vector<Size> sizes;
      std::vector<std::unique_ptr<GuardedView>> views;
      for (int view = 0; view < 3; ++view) {
        sizes.push_back({between(random, kWindowSide, 40), between(random, kWindowSide, 40)});
        views.push_back(std::make_unique<GuardedView>(random, sizes.back(), layout.step));
      }
      const test::RandomTable parts = test::random_table(random, kinds, sizes, 3);
      const WarpTable& table = parts.table;
      const TilePictures<Pixel> pictures(random, views, layout);
      for (int pattern = 0; pattern < 4; ++pattern) {
        for (const auto& view : views) view->fill(random, pattern);
        for (const Tile& tile : table.tiles) {
          ASSERT_EQ(pictures.made_by(scalar, table, tile), pictures.made_by(kernel, table, tile))
              << "table " << i << ", pattern " << pattern;
        }
      }
    }
  }

  // Every kind of block by itself, then all in one tile.
  template <class Pixel>
  static void expect_same_bits(const Layout& layout, TileKernel<Pixel> scalar, TileKernel<Pixel> kernel) {
    constexpr std::array kAll = {BlockKind::kNarrow8, BlockKind::kSigned8, BlockKind::kNarrow16,
                                 BlockKind::kWide16};
    unsigned seed = 20;
    for (const BlockKind& kind : kAll)
      expect_same_bits<Pixel>(std::span(&kind, 1), seed++, layout, scalar, kernel, 4);
    expect_same_bits<Pixel>(kAll, seed, layout, scalar, kernel, 4);
  }
};

TEST_P(EveryKernel, GivesTheScalarBitsForBytes) {
  expect_scalar_bits(std::array{BlockKind::kNarrow8}, 1);
}

TEST_P(EveryKernel, GivesTheScalarBitsForBytesWithNegativeLobes) {
  expect_scalar_bits(std::array{BlockKind::kSigned8}, 2);
}

TEST_P(EveryKernel, GivesTheScalarBitsForPairsOfBytes) {
  expect_scalar_bits(std::array{BlockKind::kNarrow16}, 3);
}

TEST_P(EveryKernel, GivesTheScalarBitsForWideFootprints) {
  expect_scalar_bits(std::array{BlockKind::kWide16}, 4);
}

TEST_P(EveryKernel, GivesTheScalarBitsForMixedTiles) {
  expect_scalar_bits(
      std::array{BlockKind::kNarrow8, BlockKind::kSigned8, BlockKind::kNarrow16, BlockKind::kWide16}, 5);
}

TEST_P(EveryKernel, GivesTheScalarBitsForTexelsOf16Bits) {
  expect_same_bits<Rgb16>({.step = 2}, run_wide_scalar, wide_kernel(GetParam()));
}

TEST_P(EveryKernel, GivesTheScalarBitsInLinearLight) {
  expect_same_bits<Rgb16>({}, run_linear_scalar, linear_kernel(GetParam()));
}

TEST_P(EveryKernel, GivesTheScalarBitsForPackedRgbOfEveryLayout) {
  for (const Layout& layout : {Layout{3, {{0, 1, 2}}}, Layout{3, {{2, 1, 0}}}, Layout{4, {{2, 1, 0}}}}) {
    expect_same_bits<Xrgb>(layout, run_tile_scalar, rgb_kernel(GetParam(), layout.step));
  }
}

TEST_P(EveryKernel, GivesTheScalarBitsForLumaOfEveryLayout) {
  for (const Layout& layout : {Layout{}, Layout{2, {{0, 0, 0}}}, Layout{2, {{1, 0, 0}}}}) {
    expect_same_bits<Luma>(layout, run_luma_scalar, luma_kernel(GetParam(), layout.step));
  }
}

TEST_P(EveryKernel, GivesTheScalarBitsForChromaOfEveryLayout) {
  for (const Layout& layout :
       {Layout{}, Layout{2, {{0, 1, 0}}}, Layout{4, {{0, 2, 0}}}, Layout{4, {{1, 3, 0}}}}) {
    expect_same_bits<Chroma>(layout, run_chroma_scalar, chroma_kernel(GetParam(), layout.step));
  }
}

TEST_P(EveryKernel, GivesTheScalarBitsForLumaAndChromaOf16Bits) {
  expect_same_bits<Luma>({.step = 2}, run_wide_luma_scalar, wide_luma_kernel(GetParam()));
  expect_same_bits<Chroma>({4, {{0, 2, 0}}}, run_wide_chroma_scalar, wide_chroma_kernel(GetParam()));
}

// A row of pixels somewhere in bytes that are to stay as they are.
template <class Pixel>
std::vector<std::byte> stored(const RowStore<Pixel>& rows, const std::vector<Pixel>& pixels, int count,
                              PixelFormat format, int x, const std::array<int, 3>& shift) {
  constexpr std::size_t kPlane = 4096;
  std::vector<std::byte> bytes(4 * kPlane, std::byte{0xa5});
  void* aligned = bytes.data();
  std::size_t room = bytes.size();
  auto* first = static_cast<std::byte*>(std::align(64, 3 * kPlane, aligned, room));
  MutableImage frame{format, {512, 1}, {}};
  for (std::size_t plane = 0; plane < 3; ++plane) {
    frame.planes[plane] = {first + plane * kPlane + shift[plane], static_cast<std::ptrdiff_t>(kPlane)};
  }
  rows.store(pixels.data(), count, frame, x, 0);
  rows.finish();
  return {first, first + 3 * kPlane};
}

template <class Pixel>
void expect_same_rows(const std::vector<Pixel>& pixels, const RowStore<Pixel>& plain,
                      const RowStore<Pixel>& rows, int step_of_counts) {
  Random random(6);
  for (const PixelFormat format : {PixelFormat::kRgbPlanar8, PixelFormat::kRgbPlanar16, PixelFormat::kRgb8,
                                   PixelFormat::kRgb16, PixelFormat::kXrgb8888}) {
    const int step = sample_bytes(format) == 2 ? 2 : format == PixelFormat::kXrgb8888 ? 4 : 1;
    for (int count = 0; count <= 200; count += step_of_counts) {
      for (int i = 0; i < 16; ++i) {
        // All alignments come up, planes alike as in a frame of our own and unlike as they may be elsewhere.
        const int x = i == 0 ? 0 : between(random, 0, 64);
        std::array<int, 3> shift{};
        if (i % 4 == 1) shift.fill(between(random, 0, 63) / step * step);
        if (i % 4 == 2)
          shift = {0, between(random, 0, 63) / step * step, between(random, 0, 63) / step * step};
        ASSERT_TRUE(stored(rows, pixels, count, format, x, shift) ==
                    stored(plain, pixels, count, format, x, shift))
            << "format " << static_cast<int>(format) << ", " << count << " pixels at " << x;
      }
    }
  }
}

TEST_P(EveryKernel, StoresRowsOfEveryLengthAtEveryAlignment) {
  Random random(6);
  std::vector<Xrgb> pixels(200);
  for (Xrgb& pixel : pixels) pixel = kBlackXrgb | (random() & 0xffffff);
  expect_same_rows<Xrgb>(pixels, {store_row_scalar, finish_rows_scalar}, row_store(GetParam()), 1);
}

TEST_P(EveryKernel, StoresRowsOf16BitsHoweverTheyAreNarrowed) {
  Random random(7);
  std::vector<Rgb16> pixels(200);
  const auto sample = [&] { return static_cast<std::uint16_t>(random()); };
  for (Rgb16& pixel : pixels) pixel = {sample(), sample(), sample(), 0};
  pixels[3] = {65535, 65408, 65407, 0};
  for (const Narrowing narrowing :
       {Narrowing::kRounded, Narrowing::kDithered, Narrowing::kFromLight, Narrowing::kFromLightDithered}) {
    expect_same_rows<Rgb16>(pixels, wide_row_store(Cpu::kScalar, narrowing),
                            wide_row_store(GetParam(), narrowing), 7);
  }
}

// A small production table, checked, then timed where that is asked for.
void expect_scalar_frame(Cpu cpu, PixelFormat format, const SampleSettings& samples, TableForm form,
                         const char* what) {
  WorkerPool pool(1);
  Rig rig = test::omnimax_rig({492, 359}, 492, {256, 256}, {"front", "left", "right", "top"});
  rig.filter.table = form;
  const WarpTable table = build_warp_table(rig, pool);
  const unsigned most = format == PixelFormat::kRgbPlanar16 ? 65535 : 255;
  const test::Faces faces = test::make_faces(rig, test::noise(7, most), format);
  ImageBuffer expected(PixelFormat::kRgbPlanar8, rig.frame.size);
  ImageBuffer got(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_table_warp(table, Cpu::kScalar, pool, samples)->warp(faces.images, expected.pixels());
  const auto warp = make_table_warp(table, cpu, pool, samples);
  warp->warp(faces.images, got.pixels());
  ASSERT_TRUE(test::same_pixels(as_const(expected.pixels()), as_const(got.pixels())));
  if (std::getenv("CUPOLA_TIME_KERNELS") == nullptr) return;
  std::vector<double> nanoseconds;
  for (int i = 0; i < 101; ++i) {
    const auto start = std::chrono::steady_clock::now();
    warp->warp(faces.images, got.pixels());
    nanoseconds.push_back(
        std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count());
  }
  std::nth_element(nanoseconds.begin(), nanoseconds.begin() + 50, nanoseconds.end());
  std::printf("%s, %s: %.2f ns a pixel of the image, median of 101 warps\n", std::string(name(cpu)).c_str(),
              what, nanoseconds[50] / static_cast<double>(table.pixels_in_image));
}

TEST_P(EveryKernel, GivesTheScalarBitsOnTheProductionTable) {
  expect_scalar_frame(GetParam(), PixelFormat::kRgbPlanar8, {}, TableForm::kFast, "fast");
  expect_scalar_frame(GetParam(), PixelFormat::kRgbPlanar8, {}, TableForm::kPrecise, "precise");
}

TEST_P(EveryKernel, GivesTheScalarBitsOnTheProductionTableFor16BitsAndInLight) {
  const SampleSettings linear{.linear_light = true};
  constexpr PixelFormat kDeep = PixelFormat::kRgbPlanar16;
  expect_scalar_frame(GetParam(), kDeep, {}, TableForm::kPrecise, "16 bits, precise");
  expect_scalar_frame(GetParam(), PixelFormat::kRgbPlanar8, linear, TableForm::kPrecise, "light, precise");
  expect_scalar_frame(GetParam(), PixelFormat::kRgbPlanar8, linear, TableForm::kFast, "light, fast");
  expect_scalar_frame(GetParam(), kDeep, linear, TableForm::kPrecise, "light of 16 bits, precise");
}

INSTANTIATE_TEST_SUITE_P(Kernels, EveryKernel,
                         testing::Values(Cpu::kScalar, Cpu::kSse4, Cpu::kAvx2, Cpu::kAvx512, Cpu::kNeon),
                         [](const auto& instance) { return std::string(name(instance.param)); });

}  // namespace
}  // namespace cupola
