// Show files: what is read into a show. What is refused is in bad_input_test.cpp.
// SPDX-License-Identifier: MIT
#include "firmware/show.h"

#include <gtest/gtest.h>

#include "firmware/command.h"
#include "pipeline/frame/error.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

TEST(Show, IsReadCueByCue) {
  TemporaryFolder folder;
  write_text(folder / "night.toml", R"(rig = "omnimax"
[[cue]]
name = "stills"
source = "stills"
file = "pictures/{view}.png"
duration_s = 2.5
[[cue]]
name = "sequence"
source = "sequence"
file = "show/{view}_%06d.png"
rate = 30
in = 5
out = 899
loop = true
then = "atlas"
[[cue]]
name = "unreached"
source = "test-pattern"
world = "grid"
then = "wait"
[[cue]]
name = "atlas"
source = "atlas"
file = "atlas.png"
layout = "3x2"
faces = ["front", "right", "back", "left", "top", "bottom"]
transition = "cut"
then = "stills"
[[cue]]
name = "end"
source = "test-pattern"
world = "grid"
then = "stop"
)");
  const Show show = load_show(folder / "night.toml", {});
  EXPECT_EQ(show.name, "night");
  EXPECT_EQ(show.rig.frame.size, (Size{1966, 1436}));
  ASSERT_EQ(show.cues.size(), 5U);
  EXPECT_EQ(show.cues[0].file, (folder / "pictures/{view}.png").string());
  EXPECT_EQ(show.cues[0].duration_s, 2.5);
  EXPECT_EQ(show.cues[0].then, 1U);
  EXPECT_EQ(show.cues[1].rate, 30.0);
  EXPECT_EQ(show.cues[1].part.in, 5);
  EXPECT_EQ(show.cues[1].part.out, 899);
  EXPECT_TRUE(show.cues[1].loop);
  EXPECT_EQ(show.cues[1].then, 3U);
  EXPECT_FALSE(show.cues[1].wait);
  EXPECT_EQ(show.cues[2].then, 3U);
  EXPECT_TRUE(show.cues[2].wait);
  EXPECT_EQ(show.cues[2].world, "grid");
  EXPECT_EQ(show.cues[3].layout.columns, 3);
  EXPECT_EQ(show.cues[3].layout.faces.size(), 6U);
  EXPECT_EQ(show.cues[3].then, 0U);
  EXPECT_EQ(show.cues[4].then, std::nullopt);
}

TEST(Show, TakesOverridesForItselfAndForItsRig) {
  const std::string lines[] = {"rig.frame.width=100", "cue.0.duration_s=3"};
  const Show show = load_show("demo", lines);
  EXPECT_EQ(show.rig.frame.size.width, 100);
  EXPECT_EQ(show.cues[0].duration_s, 3.0);
}

TEST(Show, OfTheProjectIsReadable) {
  for (const char* name : {"demo", "tree", "checkerboard", "test-patterns"}) {
    WorkerPool pool(1);
    const Show show = load_show(name, {});
    EXPECT_FALSE(show.cues.empty()) << name;
    for (const Cue& cue : show.cues) EXPECT_NE(open_source(cue, show.rig, pool), nullptr) << name;
  }
}

TEST(Grouped, SetsACommaBeforeEveryThirdDigit) {
  EXPECT_EQ(grouped(0), "0");
  EXPECT_EQ(grouped(999), "999");
  EXPECT_EQ(grouped(1000), "1,000");
  EXPECT_EQ(grouped(12345), "12,345");
  EXPECT_EQ(grouped(1234567), "1,234,567");
  EXPECT_EQ(grouped(-1000), "-1,000");
  EXPECT_EQ(grouped(-100), "-100");
}

}  // namespace
}  // namespace cupola
