// Rig files: what they give, and what is refused with file, line and key.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/rig.h"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

const std::string kFrame = "[frame]\nwidth = 100\nheight = 80\n";
const std::string kLens = "[lens]\nmodel = \"equidistant\"\n";
const std::string kFront = "[[view]]\nname = \"front\"\n";

class RigFile : public testing::Test {
 protected:
  Rig load(const std::string& text, std::vector<std::string> overrides = {}) {
    std::ofstream(file_) << text;
    return load_rig(file_, overrides);
  }
  std::string refusal(const std::string& text) {
    try {
      load(text);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  void expect_refused(const std::string& text, const std::string& words) {
    const std::string said = refusal(text);
    EXPECT_NE(said.find(words), std::string::npos) << "said: " << said << "\nexpected: " << words;
    EXPECT_NE(said.find(file_.filename().string()), std::string::npos) << said;
  }
  std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("rig_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".toml");
};

TEST_F(RigFile, EveryShippedRigLoads) {
  int count = 0;
  for (const auto& entry : std::filesystem::directory_iterator(std::string(CUPOLA_CONFIG) + "/rigs")) {
    const Rig rig = load_rig(entry.path());
    EXPECT_GE(rig.views.size(), 2U) << entry.path();
    ++count;
  }
  EXPECT_GE(count, 10);
}

TEST_F(RigFile, EveryShippedLensIsFoundByName) {
  for (const auto& entry : std::filesystem::directory_iterator(std::string(CUPOLA_CONFIG) + "/lenses")) {
    const Rig rig = load(kFrame + "[lens]\nfile = \"" + entry.path().filename().string() + "\"\n" + kFront);
    EXPECT_EQ(fault(rig.frame.lens), "") << entry.path();
  }
}

TEST_F(RigFile, DefaultsAreACentredCircleThatTouchesTheShorterSides) {
  const Rig rig = load(kFrame + kLens + kFront);
  EXPECT_EQ(rig.frame.center, Vec2(50, 40));
  EXPECT_EQ(rig.frame.radius, 40);
  EXPECT_EQ(rig.views[0].focal, Vec2(0.5, 0.5));
}

TEST_F(RigFile, TiltRaisesTheAxisAndLeavesViewsThatFollowItAlone) {
  const Rig axis = load("tilt_deg = 30\n" + kFrame + kLens + kFront);
  EXPECT_EQ(axis.views[0].forward, Vec3(0, 0, -1));
  const Vec3 up = axis.world_from_lens * Vec3{0, 0, -1};
  EXPECT_NEAR(up.y, 0.5, 1e-15);
  EXPECT_NEAR(up.z, -std::sqrt(0.75), 1e-15);
}

TEST_F(RigFile, WorldViewsStayWithTheHorizon) {
  const Rig zenith = load("views = \"world\"\ntilt_deg = 90\n" + kFrame + kLens + kFront);
  // In a zenith-centred domemaster the front of the audience is at the bottom of the frame.
  EXPECT_LT(glm::length(zenith.views[0].forward - Vec3(0, -1, 0)), 1e-15);
  EXPECT_LT(glm::length(zenith.world_from_lens * zenith.views[0].forward - Vec3(0, 0, -1)), 1e-15);
}

TEST_F(RigFile, PositionsAndTheDistanceWhereSeamsCloseShiftTheViews) {
  const std::string front = kFrame + kLens + kFront + "position_m = [0.03, -0.02, 0.06]\n";
  const Rig near = load(front + "[seams]\ndistance_m = 4\n");
  EXPECT_EQ(near.views[0].position_m, Vec3(0.03, -0.02, 0.06));
  EXPECT_EQ(near.seams.distance_m, 4.0);
  EXPECT_EQ(near.views[0].shift, Vec3(0.0075, -0.005, 0.015));
  EXPECT_FALSE(is_shifted(load(front).views[0])) << "without a distance seams close at infinity";
  const Rig zenith = load("views = \"world\"\ntilt_deg = 90\n" + front + "[seams]\ndistance_m = 4\n");
  EXPECT_LT(glm::length(zenith.world_from_lens * zenith.views[0].shift - near.views[0].shift), 1e-15);
}

TEST_F(RigFile, SeamsThatCloseTooNearAreRefused) {
  const std::string front = kFrame + kLens + kFront + "position_m = [0.3, 0, 0.4]\n";
  expect_refused(
      front + "[seams]\ndistance_m = 0.9\n",
      ":10: seams.distance_m: expected at least 1: 2 times as far as view front, which is 0.5 m off");
  EXPECT_EQ(load(front + "[seams]\ndistance_m = 1.0\n").views[0].shift, Vec3(0.3, 0.0, 0.4));
  expect_refused(front + "[seams]\ndistance_m = -3\n", "distance_m");
  expect_refused(kFrame + kLens + kFront + "position_m = [0, 0, 101]\n",
                 "position_m: expected [x, y, z] within 100 metres of the rig's centre");
  expect_refused(kFrame + kLens + kFront + "position_m = [0, 0]\n", "position_m");
}

TEST_F(RigFile, LeavesTheTablesOfHardwareToOthers) {
  load(kFrame + kLens + kFront +
       "[[camera]]\nany = 1\n[gpio]\nany = 2\n[[gpio.input]]\nany = 3\n[display]\nany = 4\n");
  expect_refused(kFrame + kLens + kFront + "[gpoi]\n", "did you mean gpio?");
}

TEST_F(RigFile, AnyPoseIsTakenAndMadeOrthogonal) {
  const Rig rig = load(
      kFrame + kLens +
      "[[view]]\nname = \"wide\"\nforward = [-1, 0, -1]\nup = [0, 2, 0.5]\nfov_deg = 120\nfov_y_deg = 100\n");
  const View& view = rig.views[0];
  EXPECT_NEAR(glm::dot(view.forward, view.up), 0, 1e-15);
  EXPECT_NEAR(glm::dot(view.right, view.up), 0, 1e-15);
  EXPECT_NEAR(view.focal.x, 0.5 / std::tan(60 * 3.14159265358979 / 180), 1e-12);
}

TEST_F(RigFile, PaperPresetIsTheFilterOf1986AndKeysOverrideIt) {
  const Rig rig = load(kFrame + kLens + kFront + "[filter]\npreset = \"paper\"\nalpha = 3\n");
  EXPECT_EQ(rig.filter.radius, 2.0);
  EXPECT_EQ(rig.filter.alpha, 3.0);
  EXPECT_EQ(load(kFrame + kLens + kFront, {"filter.radius=1.5"}).filter.radius, 1.5);
}

TEST_F(RigFile, EveryKernelComesWithItsOwnNumbers) {
  const auto filter = [&](const std::string& kernel) {
    return load(kFrame + kLens + kFront + "[filter]\nkernel = \"" + kernel + "\"\n").filter;
  };
  EXPECT_EQ(filter("gaussian").kernel, Kernel::kGaussian);
  EXPECT_EQ(filter("gaussian").alpha, 6.0);
  EXPECT_EQ(filter("gaussian").rec, 0.5);
  EXPECT_EQ(filter("robidoux").radius, 2.0);
  EXPECT_EQ(filter("robidoux").rec, 0.0);
  EXPECT_NEAR(filter("jinc").radius, 3.2383, 1e-4);
  EXPECT_EQ(filter("optimal").noise, kDefaultNoise);
  const std::string optimal = kFrame + kLens + kFront + "[filter]\nkernel = \"optimal\"\n";
  EXPECT_EQ(load(optimal + "noise = 0.01\ntable = \"precise\"\n").filter.noise, 0.01);
}

TEST_F(RigFile, NumbersOfAnotherKernelAreRefused) {
  const std::string start = kFrame + kLens + kFront + "[filter]\n";
  expect_refused(start + "kernel = \"robidou\"\n", "robidoux");
  expect_refused(start + "kernel = \"optimal\"\nalpha = 2\n", "belongs to gaussian");
  expect_refused(start + "kernel = \"optimal\"\nradius = 2\n", "filter.radius");
  expect_refused(start + "kernel = \"jinc\"\nnoise = 0.001\n", "belongs to optimal");
  expect_refused(start + "kernel = \"optimal\"\nnoise = 0\n", "filter.noise");
  expect_refused(start + "preset = \"paper\"\nkernel = \"jinc\"\n", "filter.kernel");
  for (const char* other : {"preset = \"default\"", "kernel = \"optimal\"", "alpha = 2", "radius = 2",
                            "rec = 1", "noise = 0.1", "table = \"precise\""}) {
    expect_refused(start + "budget_ms = 8.0\n" + other + "\n", "beside budget_ms");
  }
  for (const char* budget : {"0", "-1", "nan", "inf", "1e9", "\"8\"", "[8]"}) {
    expect_refused(start + "budget_ms = " + budget + "\n", "filter.budget_ms");
  }
}

TEST_F(RigFile, BadRigsAreRefused) {
  expect_refused(kFrame + "radius = nan\n" + kLens + kFront, "frame.radius");
  expect_refused(kFrame + "radius = -1\n" + kLens + kFront, "frame.radius");
  expect_refused(kFrame + "[lens]\nmodel = \"polynomial\"\ncoefficients = [0, 2, 0, -1]\n" + kFront,
                 "0.816497");
  expect_refused(kFrame + "[lens]\nmodel = \"equidistan\"\n" + kFront, "equidistant");
  expect_refused(kFrame + "[lens]\nfile = \"nothing\"\n" + kFront, "lens.file");
  expect_refused(kFrame + kLens + "[[view]]\nname = \"front\"\nforward = [0, 0, 0]\nup = [0, 1, 0]\n",
                 "forward");
  expect_refused(kFrame + kLens + "[[view]]\nname = \"a\"\nforward = [0, 2, 0]\nup = [0, 1, 0]\n",
                 "parallel");
  expect_refused(kFrame + kLens + "[[view]]\nname = \"a\"\n", "name");
  expect_refused(kFrame + kLens + "[[view]]\nname = \"front\"\nfov_deg = 180\n", "fov_deg");
  expect_refused(kFrame + kLens + kFront + kFront, "another view");
  expect_refused(kFrame + kLens + kFront + "[filtre]\n", "did you mean filter");
  expect_refused(kFrame + kLens, "view");
  expect_refused(kLens + kFront, "frame");
  expect_refused(kFrame + kFront, "lens");
  expect_refused("[frame]\nwidth = 65536\nheight = 10\n" + kLens + kFront, "frame.width");
  expect_refused("tilt_deg = inf\n" + kFrame + kLens + kFront, "tilt_deg");
  expect_refused(kFrame + kLens + "[[view]]\nname = \"front\"\nsize = [0, 10]\n", "size");
  expect_refused("[frame]\nmodel = \"cube\"\nwidth = 100\nheight = 80\nlayout = \"3x2\"\n" + kFront,
                 "layout");
  expect_refused(kFrame + kLens + kFront + "[filter]\nalpha = 50\nradius = 8\n", "filter.alpha");
  EXPECT_THROW(load_rig("/no/such/rig.toml"), InputError);
}

TEST_F(RigFile, ALensFileThatNamesAnotherFileIsRefused) {
  const std::filesystem::path lens = file_.parent_path() / "loop_lens.toml";
  std::ofstream(lens) << "file = \"loop_lens.toml\"\n";
  EXPECT_THROW(load(kFrame + "[lens]\nfile = \"loop_lens.toml\"\n" + kFront), InputError);
}

TEST_F(RigFile, ViewsTakeTheSizesOfTheirPicturesUnlessTheRigSaysOtherwise) {
  Rig rig = load(kFrame + kLens + "[[view]]\nname = \"front\"\nsize = [64, 60]\n");
  const Size wrong{64, 64};
  EXPECT_THROW(set_view_sizes(rig, std::span(&wrong, 1)), InputError);
  const Size right{64, 60};
  set_view_sizes(rig, std::span(&right, 1));
  EXPECT_EQ(rig.views[0].size, right);
  EXPECT_THROW(set_view_sizes(rig, {}), InputError);
}

}  // namespace
}  // namespace cupola
