// cupola calibrate, from pictures to a dome: an analytic world through four imperfect cameras.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <map>
#include <nlohmann/json.hpp>

#include "pipeline/frame/still.h"
#include "pipeline/optics/calibration.h"
#include "pipeline/optics/rig.h"
#include "tests/calibrate/simulated_rig.h"
#include "tests/firmware/analytic_world.h"
#include "tests/firmware/live_show.h"
#include "tests/firmware/postcard_camera.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;

constexpr Size kPicture{480, 480};
const char* const kNames[] = {"front", "left", "right", "top"};

std::string rig_text() {
  std::string text = fmt::format("[frame]\nwidth = {}\nheight = {}\n[lens]\nmodel = \"equidistant\"\n",
                                 kDomeSide, kDomeSide);
  for (const char* name : kNames) text += fmt::format("[[view]]\nname = \"{}\"\nfov_deg = 120\n", name);
  return text;
}

constexpr double kSphere_m = 1.5;

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
  EXPECT_GT(after.pixels, kDomeSide * kDomeSide / 4);
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

// What a sensor of its own colours makes of an RGB picture, as NV12.
NativeBuffer developed(const ImageBuffer& rgb, const ViewColour& colours) {
  const Size size = rgb.size();
  NativeBuffer picture(NativeLayout::kNv12, YuvColour{}, size);
  const auto [red, blue] = weights_of(YuvMatrix::kBt601);
  for (int y = 0; y < size.height; y += 2) {
    for (int x = 0; x < size.width; x += 2) {
      double u = 0.0;
      double v = 0.0;
      for (int i = 0; i < 4; ++i) {
        std::array<double, 3> seen{};
        for (int c = 0; c < 3; ++c)
          seen[static_cast<std::size_t>(c)] = std::clamp(
              colours.of(static_cast<std::size_t>(c), sample(rgb, c, x + i % 2, y + i / 2)), 0.0, 255.0);
        const double luma = red * seen[0] + (1.0 - red - blue) * seen[1] + blue * seen[2];
        *sample_at(picture.pixels(), 0, x + i % 2, y + i / 2) =
            static_cast<std::uint8_t>(16.5 + luma * 219.0 / 255.0);
        u += 0.25 * (seen[2] - luma) / (2.0 * (1.0 - blue));
        v += 0.25 * (seen[0] - luma) / (2.0 * (1.0 - red));
      }
      *sample_at(picture.pixels(), 1, x / 2, y / 2) = static_cast<std::uint8_t>(128.5 + u * 224.0 / 255.0);
      *sample_at(picture.pixels(), 2, x / 2, y / 2) = static_cast<std::uint8_t>(128.5 + v * 224.0 / 255.0);
    }
  }
  return picture;
}

// Cameras that are none too well made, run freely and see colours each in its own way; the first one's
// colours are known.
TEST_F(Calibrate, BringsLiveCamerasOfOtherColoursOntoTheDome) {
  EXPECT_EQ(calibrate({"--out", path("live.toml"), "--model", "radial"}).code, 0);
  const std::string feathered[] = {"seams.feather_deg=4"};
  const Rig rig = load_rig(path("live.toml"), feathered);
  const std::array<ViewColour, 4> seen = {{{{0.92, 0.95, 0.97}, {4.0, 2.0, 3.0}},
                                           {{1.05, 1.0, 0.92}, {-3.0, 0.0, 2.0}},
                                           {{0.9, 0.96, 1.04}, {5.0, 4.0, 1.0}},
                                           {{0.97, 1.03, 0.95}, {0.0, -2.0, 3.0}}}};
  test::LiveColours colours{.match = true, .locked = {}};
  colours.locked[0].emplace();
  for (std::size_t c = 0; c < 3; ++c) {
    colours.locked[0]->gain[c] = 1.0 / seen[0].gain[c];
    colours.locked[0]->offset[c] = -seen[0].offset[c] / seen[0].gain[c];
  }
  test::LiveShow show(
      [&](std::size_t c, FakeCameraDevice& device, CameraSetup& setup) {
        device.width = setup.width = kPicture.width;
        device.height = setup.height = kPicture.height;
        device.jitter = std::chrono::milliseconds(1);
        device.drift_ppm = 40.0 * static_cast<double>(c) - 60.0;
      },
      rig,
      [&](std::size_t c, std::unique_ptr<Camera> device, FakeClock&) {
        return std::make_unique<test::PostcardCamera>(
            std::move(device), developed(read_still(path(fmt::format("{}.png", kNames[c]))), seen[c]));
      },
      colours,
      {.sync = {.tolerance = std::chrono::microseconds(8333)},
       .align = false,
       .match_colours = false,
       .exposure = {}});
  ImageBuffer frame(PixelFormat::kRgb8, {kDomeSide, kDomeSide});
  const auto keep = [&](const DisplayBuffer& buffer) {
    for (int y = 0; y < kDomeSide; ++y) {
      const auto* from = reinterpret_cast<const std::uint32_t*>(buffer.data + y * buffer.stride);
      auto* into = frame.pixels().samples<std::uint8_t>(0, y);
      for (int i = 0; i < 3 * kDomeSide; ++i)
        into[i] = static_cast<std::uint8_t>(from[i / 3] >> (16 - 8 * (i % 3)));
    }
  };
  show.play(std::chrono::milliseconds(100), [&](int, const DisplayBuffer& buffer) { keep(buffer); });
  const DomeError before = dome_error(frame, show.frames->rig());
  show.play(std::chrono::seconds(40), [&](int flip, const DisplayBuffer& buffer) {
    if (flip == 2390) keep(buffer);
  });
  const DomeError after = dome_error(frame, show.frames->rig());
  RecordProperty("smooth_before", std::to_string(before.smooth));
  RecordProperty("smooth_after", std::to_string(after.smooth));
  RecordProperty("rms_after", std::to_string(after.rms));
  RecordProperty("mark_after", std::to_string(after.mark));
  EXPECT_GT(before.smooth, 8.0) << "the colours are not worth matching";
  EXPECT_GT(after.marks, 60);
  EXPECT_LT(after.mark, 0.5);
  EXPECT_LT(after.rms, 1.0);
  EXPECT_LT(after.smooth, 3.0);
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
