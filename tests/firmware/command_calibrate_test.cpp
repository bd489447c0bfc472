// cupola calibrate, from pictures to a dome: an analytic world through four imperfect cameras.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "pipeline/frame/still.h"
#include "pipeline/optics/calibration.h"
#include "pipeline/optics/frame_geometry.h"
#include "pipeline/optics/rig.h"
#include "tests/calibrate/simulated_rig.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

constexpr Size kPicture{480, 480};
constexpr int kSide = 360;  // of the dome's frame: a pixel is half a degree
const char* const kNames[] = {"front", "left", "right", "top"};

std::string rig_text() {
  std::string text =
      fmt::format("[frame]\nwidth = {}\nheight = {}\n[lens]\nmodel = \"equidistant\"\n", kSide, kSide);
  for (const char* name : kNames) text += fmt::format("[[view]]\nname = \"{}\"\nfov_deg = 120\n", name);
  return text;
}

// A smooth sky, and 97 marks on it: bright spots with a half width of 1.2 degrees.
double sky(const Vec3& d, int channel) {
  return 110.0 + 40.0 * std::sin(2.0 * d.x + channel) * std::cos(1.7 * d.y) +
         20.0 * std::sin(2.3 * d.z + 1.0);
}
std::vector<Vec3> marks() {
  std::vector<Vec3> places;
  for (int i = 0; i < 97; ++i) {
    const double z = -1.0 + (i + 0.5) / 97.0;
    const double r = std::sqrt(1.0 - z * z);
    places.emplace_back(r * std::cos(2.399963 * i), r * std::sin(2.399963 * i), z);
  }
  return places;
}
double spot(const Vec3& off) {
  return 70.0 * std::exp(-glm::dot(off, off) / (2.0 * 0.018 * 0.018));
}

constexpr double kSphere_m = 1.5;

Vec3 world(const Vec3& d, const std::vector<Vec3>& places) {
  double marked = 0.0;
  for (const Vec3& place : places) {
    const Vec3 off = d - place;
    if (std::abs(off.x) < 0.1 && std::abs(off.y) < 0.1 && std::abs(off.z) < 0.1) marked += spot(off);
  }
  return {sky(d, 0) + marked, sky(d, 1) + marked, sky(d, 2) + marked};
}

// Pictures of the board, made once for all tests here: they take seconds.
class Calibrate : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    folder_ = new TemporaryFolder;
    cameras_ = new std::vector<SimulatedCamera>(simulated_cameras(kPicture));
    const Board board;
    const std::vector<SimulatedShot> shots = simulated_shots(*cameras_, board, 9, 3);
    const std::vector<Vec3> places = marks();
    std::filesystem::create_directory(*folder_ / "near");
    Vec3 middle{0.0};
    for (const SimulatedCamera& camera : *cameras_) middle += camera.place / 4.0;
    for (std::size_t c = 0; c < 4; ++c) {
      const Photographer photographer((*cameras_)[c]);
      const std::filesystem::path views = *folder_ / "shots" / kNames[c];
      std::filesystem::create_directories(views);
      for (std::size_t s = 0; s < shots.size(); ++s) {
        const std::vector<int>& seen_by = shots[s].cameras;
        if (std::find(seen_by.begin(), seen_by.end(), static_cast<int>(c)) == seen_by.end()) continue;
        write_png(
            views / fmt::format("{:04}.png", s + 1),
            photographer.take(board, shots[s].board, 2.0, static_cast<std::uint32_t>(100 * c + s)).pixels());
      }
      write_png(*folder_ / fmt::format("{}.png", kNames[c]),
                photographer.take([&](const Vec3& d) { return world(d, places); }).pixels());
      // The same painted on a sphere about the middle of the cameras.
      const Vec3 eye = ((*cameras_)[c].place - middle) / kSphere_m;
      const ImageBuffer near = photographer.take([&](const Vec3& d) {
        const double along = glm::dot(eye, d);
        return world(eye + d * (std::sqrt(along * along + 1.0 - glm::dot(eye, eye)) - along), places);
      });
      write_png(*folder_ / "near" / fmt::format("{}.png", kNames[c]), near.pixels());
    }
    write_text(*folder_ / "rig.toml", rig_text());
  }
  static void TearDownTestSuite() {
    delete folder_;
    delete cameras_;
    folder_ = nullptr;
    cameras_ = nullptr;
  }
  static std::string path(const std::string& name) { return (*folder_ / name).string(); }
  static Outcome calibrate(std::vector<std::string> more = {}) {
    std::vector<std::string> arguments = {"calibrate", "--rig", path("rig.toml")};
    const std::map<std::string, std::string> usual = {
        {"--from", path("shots")}, {"--board", "9x6"}, {"--square-mm", "25"}};
    for (const auto& [name, value] : usual) {
      if (std::find(more.begin(), more.end(), name) != more.end()) continue;
      arguments.push_back(name);
      arguments.push_back(value);
    }
    arguments.insert(arguments.end(), more.begin(), more.end());
    return call(arguments);
  }
  static TemporaryFolder* folder_;
  static std::vector<SimulatedCamera>* cameras_;
};
TemporaryFolder* Calibrate::folder_ = nullptr;
std::vector<SimulatedCamera>* Calibrate::cameras_ = nullptr;

struct DomeError {
  double mark = 0.0;    // pixels, the most any mark is off
  double smooth = 0.0;  // steps of 255, the most where there is no mark
  int marks = 0;
  int pixels = 0;
};

// A dome frame of the world against the world itself.
DomeError dome_error(const ImageBuffer& frame, const Rig& rig) {
  const std::vector<Vec3> places = marks();
  std::vector<Vec3> rays(kSide * kSide, Vec3{0.0});
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      DirectionAndSlope looking;
      if (ray(rig.frame, {x + 0.5, y + 0.5}, looking) && owner(rig.views, looking.direction) >= 0)
        rays[static_cast<std::size_t>(y * kSide + x)] = looking.direction;
    }
  }
  // Whether all around (x, y) is seen.
  const auto inside = [&](int x, int y, int reach) {
    for (int j = -reach; j <= reach; ++j) {
      for (int i = -reach; i <= reach; ++i) {
        if (x + i < 0 || y + j < 0 || x + i >= kSide || y + j >= kSide) return false;
        if (rays[static_cast<std::size_t>((y + j) * kSide + x + i)] == Vec3{0.0}) return false;
      }
    }
    return true;
  };
  DomeError error;
  for (int y = 0; y < kSide; ++y) {
    for (int x = 0; x < kSide; ++x) {
      if (!inside(x, y, 2)) continue;
      const Vec3& d = rays[static_cast<std::size_t>(y * kSide + x)];
      if (std::any_of(places.begin(), places.end(),
                      [&](const Vec3& place) { return glm::length(d - place) < 0.11; }))
        continue;
      ++error.pixels;
      for (int c = 0; c < 3; ++c)
        error.smooth = std::max(error.smooth, std::abs(sample(frame, c, x, y) - sky(d, c)));
    }
  }
  for (const Vec3& place : places) {
    // The pixel that is nearest to it.
    std::size_t nearest = 0;
    for (std::size_t i = 0; i < rays.size(); ++i) {
      if (glm::dot(rays[i], place) > glm::dot(rays[nearest], place)) nearest = i;
    }
    const int x0 = static_cast<int>(nearest) % kSide;
    const int y0 = static_cast<int>(nearest) / kSide;
    constexpr int kReach = 8;
    if (!inside(x0, y0, kReach)) continue;
    Vec2 there{0.0};
    Vec2 here{0.0};
    double weight_there = 0.0;
    double weight_here = 0.0;
    for (int y = y0 - kReach; y <= y0 + kReach; ++y) {
      for (int x = x0 - kReach; x <= x0 + kReach; ++x) {
        const Vec3& d = rays[static_cast<std::size_t>(y * kSide + x)];
        const double truth = spot(d - place);
        const double shown = sample(frame, 1, x, y) - sky(d, 1);
        if (truth < 0.5 && shown < 3.0) continue;
        there += truth * Vec2{x, y};
        weight_there += truth;
        here += shown * Vec2{x, y};
        weight_here += shown;
      }
    }
    error.mark = std::max(error.mark, glm::length(here / weight_here - there / weight_there));
    ++error.marks;
  }
  return error;
}

DomeError warped(const std::string& rig, const std::string& folder, const std::string& out,
                 const std::vector<std::string>& overrides = {}) {
  std::vector<std::string> arguments = {"warp", "--rig", rig, "--out", out};
  for (const std::string& line : overrides) arguments.insert(arguments.end(), {"--set", line});
  for (const char* name : kNames) {
    arguments.push_back("--view");
    arguments.push_back(fmt::format("{}={}/{}.png", name, folder, name));
  }
  const Outcome outcome = call(arguments);
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  return dome_error(read_still(out), load_rig(rig, overrides));
}

TEST_F(Calibrate, BringsAWorldThroughImperfectCamerasOntoTheDomeWhereItBelongs) {
  const Outcome outcome = calibrate();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("camera left: "));
  EXPECT_THAT(outcome.out, HasSubstr("seam front, left: "));
  EXPECT_THAT(outcome.out, HasSubstr("written: " + path("rig-calibrated.toml")));
  const std::string folder = folder_->path().string();
  const DomeError before = warped(path("rig.toml"), folder, path("before.png"));
  const DomeError after = warped(path("rig-calibrated.toml"), folder, path("after.png"));
  RecordProperty("mark_before", std::to_string(before.mark));
  RecordProperty("mark_after", std::to_string(after.mark));
  RecordProperty("smooth_after", std::to_string(after.smooth));
  EXPECT_GT(before.mark, 1.5) << "the cameras are not worth calibrating";
  EXPECT_GT(after.marks, 60);
  EXPECT_LT(after.mark, 0.5);
  EXPECT_GT(after.pixels, kSide * kSide / 4);
  EXPECT_LT(after.smooth, 2.0);
}

// Cameras 6 cm off their middle, 1.5 m from what they see: 2.4 degrees, and nearly 5 pixels, of parallax.
TEST_F(Calibrate, KnowsWhereTheCamerasAreSoThatSeamsCloseAtADistance) {
  EXPECT_EQ(calibrate({"--out", path("near.toml"), "--model", "radial"}).code, 0);
  const DomeError far = warped(path("near.toml"), path("near"), path("far-frame.png"));
  const DomeError near = warped(path("near.toml"), path("near"), path("near-frame.png"),
                                {fmt::format("seams.distance_m={}", kSphere_m)});
  RecordProperty("mark_far", std::to_string(far.mark));
  RecordProperty("mark_near", std::to_string(near.mark));
  RecordProperty("smooth_near", std::to_string(near.smooth));
  EXPECT_GT(far.mark, 1.5);
  EXPECT_GT(near.marks, 60);
  EXPECT_LT(near.mark, 0.5);
  EXPECT_LT(near.smooth, 2.0);
}

TEST_F(Calibrate, SaysTheSameInJson) {
  const Outcome outcome = calibrate({"--json", "--out", path("again.toml"), "--model", "radial"});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const auto json = nlohmann::json::parse(outcome.out);
  ASSERT_EQ(json["cameras"].size(), 4U);
  EXPECT_EQ(json["cameras"][1]["view"], "left");
  EXPECT_LT(json["cameras"][1]["rms_texels"], 0.3);
  EXPECT_EQ(json["cameras"][1]["model"], "radial");
  EXPECT_EQ(json["seams"].size(), 5U);
  EXPECT_TRUE(json["troubles"].empty());
}

TEST_F(Calibrate, RefusesWhatCannotBeMeant) {
  const auto refused = [&](std::vector<std::string> more, const std::string& words) {
    const Outcome outcome = calibrate(std::move(more));
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(words));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  };
  const std::filesystem::path one = *folder_ / "one" / "front";
  std::filesystem::create_directories(one);
  std::filesystem::copy(*folder_ / "shots" / "front" / "0001.png", one);
  refused({"--board", "10x7", "--from", path("one")}, "shows one of 9 x 6: try --board 9x6");
  refused({"--board", "8x6"}, "looks the same upside down");
  refused({"--from", path("nowhere")}, "expected a folder of pictures");
  refused({"--square-mm", "0"}, "expected millimetres");
  refused({"--out", "/tmp/elsewhere.toml"}, "expected a name in the rig's folder");
  refused({"--out", path("rig.png")}, "ends in .toml");
  refused({"--set", "view.0.size=[100, 100]", "--from", path("one")},
          "expected a picture of 100 x 100 texels, as the rig file says");
  refused({"--model", "pinhole"}, "--model");
}

TEST_F(Calibrate, SaysWhichCamerasHaveTooFewShots) {
  const std::filesystem::path few = *folder_ / "few";
  std::filesystem::copy(*folder_ / "shots", few, std::filesystem::copy_options::recursive);
  int left = 0;
  for (const auto& file : std::filesystem::directory_iterator(few / "left")) {
    if (++left > 4) std::filesystem::remove(file.path());
  }
  std::filesystem::remove_all(few / "top");
  const Outcome outcome = calibrate({"--from", few.string(), "--out", path("few.toml"), "--model", "radial"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_THAT(outcome.err, HasSubstr("shots show the whole board: expected 6 or more"));
  EXPECT_THAT(outcome.err, HasSubstr("camera top: no pictures"));
  EXPECT_THAT(outcome.out, HasSubstr("camera left: as in the rig file"));
  const Rig rig = load_rig(path("few.toml"));
  EXPECT_EQ(rig.views[1].distortion, Distortion::kNone);
  EXPECT_EQ(rig.views[2].distortion, Distortion::kRadialTangential);
}

}  // namespace
}  // namespace cupola
