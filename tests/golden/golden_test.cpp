// What must not change by accident: the bytes of warp tables, and small pictures made from end to end.
//
// With CUPOLA_WRITE_GOLDEN=1 in the environment the pictures are written instead of compared: look at them,
// then commit.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cstdlib>
#include <cstring>
#include <filesystem>

#include "pipeline/frame/still.h"
#include "pipeline/source/generated_source.h"
#include "pipeline/warp/frame_warp.h"
#include "pipeline/warp/table_build.h"
#include "tests/warp/faces.h"

namespace cupola {
namespace {

// FNV-1a, 64 bits, over values without padding.
class Hash {
 public:
  template <class Value>
  void add(const Value& value) {
    std::array<unsigned char, sizeof(Value)> bytes;
    std::memcpy(bytes.data(), &value, sizeof(Value));
    for (const unsigned char byte : bytes) value_ = (value_ ^ byte) * 0x100000001b3U;
  }
  std::uint64_t value() const { return value_; }

 private:
  std::uint64_t value_ = 0xcbf29ce484222325U;
};

std::uint64_t hash_of(const WarpTable& table) {
  Hash hash;
  for (const Tile& tile : table.tiles) hash.add(tile);
  for (const Block& block : table.blocks) hash.add(block);
  for (const Window& window : table.windows) hash.add(window);
  for (const WeightLine& line : table.lines) hash.add(line);
  return hash.value();
}

struct GoldenTable {
  const char* rig;
  int face;
  const char* setting;
  std::uint64_t hash;
};

class TableBytes : public testing::TestWithParam<GoldenTable> {};

// The same constants for every compiler, instruction set and optimisation: tables are built once and loaded
// anywhere.
TEST_P(TableBytes, AreTheSameOnEveryMachine) {
  WorkerPool pool(2);
  const std::vector<std::string> overrides = {GetParam().setting};
  Rig rig = load_rig(std::string(CUPOLA_CONFIG) + "/rigs/" + GetParam().rig + ".toml", overrides);
  set_view_sizes(rig, std::vector<Size>(rig.views.size(), Size{GetParam().face, GetParam().face}));
  EXPECT_EQ(hash_of(build_warp_table(rig, pool)), GetParam().hash);
}

INSTANTIATE_TEST_SUITE_P(
    Rigs, TableBytes,
    testing::Values(GoldenTable{"omnimax", 512, "filter.table=fast", 0xf52274398940aaf6},
                    GoldenTable{"omnimax", 512, "filter.table=precise", 0x3069002ed962e05f},
                    GoldenTable{"omnimax", 512, "filter.preset=paper", 0x22c1674335b35eb6},
                    GoldenTable{"domemaster-1k-5", 512, "filter.table=fast", 0x857b02712edbd0f0},
                    GoldenTable{"chrome-ball", 256, "filter.table=fast", 0x371d65760385ba64},
                    GoldenTable{"mercator", 256, "filter.table=fast", 0xcaf2c21b334cc1be}),
    [](const auto& instance) { return "Table" + std::to_string(instance.index); });

struct GoldenPicture {
  const char* world;
  Method method;
};

class Picture : public testing::TestWithParam<GoldenPicture> {};

// Generated faces use the C library's functions, whose last bits differ between machines: a texel may round
// the other way, so one step of difference is allowed.
TEST_P(Picture, IsTheOneThatWasLookedAt) {
  const auto [world, method] = GetParam();
  WorkerPool pool(2);
  const Rig rig = test::omnimax_rig({240, 175}, 240, {128, 128}, {"front", "left", "right", "top"});
  const auto warp = make_frame_warp(rig, method, best_cpu(), pool);
  GeneratedSource source(rig.views, rig.world_from_lens, make_world(world), 60.0, pool);
  source.prepare(warp->needed());
  FaceSet set;
  source.fetch(30, set);
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  warp->warp(set.faces, frame.pixels());

  const std::filesystem::path file = std::string(CUPOLA_GOLDEN) + "/" + world + "_" +
                                     std::string(kMethodNames[static_cast<std::size_t>(method)]) + ".png";
  if (std::getenv("CUPOLA_WRITE_GOLDEN") != nullptr) {
    write_png(file, as_const(frame.pixels()));
    return;
  }
  const ImageBuffer golden = read_still(file);
  ASSERT_EQ(golden.size(), frame.size());
  int samples = 0;
  int different = 0;
  for (int channel = 0; channel < 3; ++channel) {
    for (int y = 0; y < 175; ++y) {
      for (int x = 0; x < 240; ++x) {
        const int steps = golden.pixels().samples<std::uint8_t>(channel, y)[x] -
                          as_const(frame.pixels()).samples<std::uint8_t>(channel, y)[x];
        different += std::abs(steps) > 1 ? 1 : 0;
        ++samples;
      }
    }
  }
  EXPECT_LE(different, samples / 1000);
}

INSTANTIATE_TEST_SUITE_P(Worlds, Picture,
                         testing::Values(GoldenPicture{"demo", Method::kEwa},
                                         GoldenPicture{"tree", Method::kEwa},
                                         GoldenPicture{"grid", Method::kEwa},
                                         GoldenPicture{"checker", Method::kNearest},
                                         GoldenPicture{"bars", Method::kBilinear}),
                         [](const auto& instance) { return std::string(instance.param.world); });

}  // namespace
}  // namespace cupola
