// cupola check of a recording: four cameras look at one world, and one of them is not where its rig says.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <gmock/gmock.h>

#include <cmath>
#include <cstdio>
#include <map>

#include "hal/camera/recording_file.h"
#include "pipeline/calibrate/pose.h"
#include "pipeline/calibrate/seam_match.h"
#include "tests/calibrate/simulated_rig.h"
#include "tests/firmware/program.h"

namespace cupola {
namespace {

using testing::HasSubstr;
using namespace std::chrono_literals;

constexpr Size kPicture{320, 320};
constexpr double kFocal = 92.4;  // texels
const char* const kNames[] = {"front", "left", "right", "top"};

// Spots of several sizes all over, and a slow change of brightness.
double world(const Vec3& d) {
  double sum = 0.0;
  for (int i = 0; i < 12; ++i) {
    const double turn = 2.399963 * i;
    const double z = 1.0 - (2.0 * i + 1.0) / 12.0;
    const double r = std::sqrt(1.0 - z * z);
    const Vec3 along{r * std::cos(turn), r * std::sin(turn), z};
    sum += std::cos((14.0 + 5.0 * i) * glm::dot(along, d) + i * i);
  }
  return 120.0 + 20.0 * sum;
}

GreyPicture taken(const View& view) {
  const ImageBuffer rgb = Photographer({view, {}}).take([](const Vec3& d) { return Vec3{world(d)}; });
  GreyPicture picture{view.size, {}};
  for (int y = 0; y < view.size.height; ++y) {
    const auto* row = rgb.pixels().samples<std::uint8_t>(0, y);
    for (int x = 0; x < view.size.width; ++x) picture.texels.push_back(row[3 * x]);
  }
  return picture;
}

CameraMode mode_of(int width) {
  CameraMode mode;
  mode.format = CameraFormat::kGrey;
  mode.width = width;
  mode.height = kPicture.height;
  mode.rate = 10.0;
  mode.crop = {0, 0, width, kPicture.height};
  mode.full_range = true;
  return mode;
}

// Two seconds at 10 a second; all in step but `late`, and cropped to `width` before the first of them.
void record(const std::filesystem::path& file, const GreyPicture& picture,
            std::chrono::nanoseconds late = 0ns, int width = kPicture.width) {
  RecordingWriter writer(file);
  CameraRecord record;
  record.mode = mode_of(kPicture.width);
  ASSERT_TRUE(writer.append(record));
  if (width != kPicture.width) {
    record.mode = mode_of(width);
    ASSERT_TRUE(writer.append(record));
  }
  record.kind = RecordKind::kFrame;
  for (int i = 0; i <= 20; ++i) {
    record.seen_at = i * 100ms + late + 5ms;
    record.frame.format = CameraFormat::kGrey;
    record.frame.width = width;
    record.frame.height = kPicture.height;
    record.frame.planes[0] = {picture.texels.data(), kPicture.width, picture.texels.size()};
    record.frame.sequence = static_cast<std::uint64_t>(i);
    record.frame.captured_at = i * 100ms + late;
    ASSERT_TRUE(writer.append(record));
  }
}

class Seams : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    rig_ = new Rig;
    rig_->frame.size = {400, 400};
    rig_->frame.center = {200.0, 200.0};
    rig_->frame.radius = 200.0;
    rig_->frame.lens = equidistant(180.0);
    rig_->views = nominal_views(kPicture);
    pictures_ = new std::map<std::string, GreyPicture>;
    for (const View& view : rig_->views) (*pictures_)[view.name] = taken(view);
    for (const double texels : {1.5, 5.0}) {
      View left = rig_->views[1];
      set_axes(left, turn_about(texels / kFocal / 2.0 * left.up) * camera_axes(left));
      (*pictures_)[fmt::format("left off by {}", texels)] = taken(left);
    }
  }
  static void TearDownTestSuite() {
    delete rig_;
    delete pictures_;
    rig_ = nullptr;
    pictures_ = nullptr;
  }
  Seams() {
    std::filesystem::create_directory(folder_ / "r");
    std::string text = "[frame]\nwidth = 400\nheight = 400\n[lens]\nmodel = \"equidistant\"\n";
    for (const char* name : kNames) {
      text += fmt::format(
          "[[view]]\nname = \"{0}\"\nfov_deg = 120\n[[camera]]\nview = \"{0}\"\ndevice = \"camera {0}\"\n",
          name);
      record(folder_ / "r" / fmt::format("{}.camera", name), pictures_->at(name));
    }
    write_text(folder_ / "rig.toml", text);
  }
  std::filesystem::path recording(const char* name) const {
    return folder_ / "r" / fmt::format("{}.camera", name);
  }
  Outcome check(std::vector<std::string> more = {}) const {
    std::vector<std::string> words = {"check", "--rig", (folder_ / "rig.toml").string(), "--replay",
                                      (folder_ / "r").string()};
    words.insert(words.end(), more.begin(), more.end());
    return call(words);
  }
  static std::string line_of(const std::string& text, const std::string& begin) {
    const std::size_t at = text.find(begin);
    return at == std::string::npos ? "" : text.substr(at, text.find('\n', at) - at);
  }

  TemporaryFolder folder_;
  static Rig* rig_;
  static std::map<std::string, GreyPicture>* pictures_;
};
Rig* Seams::rig_ = nullptr;
std::map<std::string, GreyPicture>* Seams::pictures_ = nullptr;

TEST_F(Seams, AreToldInTexelsOfARecording) {
  record(recording("left"), pictures_->at("left off by 1.5"));
  const Outcome outcome = check();
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_THAT(outcome.out, HasSubstr("camera left: camera left: GREY 320 x 320, 20 frames, 10.00 a second"));
  SeamMatch match(*rig_, 0, 1);
  match.look(pictures_->at("front"), pictures_->at("left off by 1.5"));
  const SeamMeasure left = match.measure();
  EXPECT_NEAR(left.median, 1.5, 0.25);
  EXPECT_EQ(line_of(outcome.out, "seam front, left"),
            fmt::format("seam front, left: {:.2f} texels apart (median of {} places, 95 % within {:.2f}), "
                        "mostly {:.1f} left",
                        left.median, left.shifts.size() - left.strays, left.most, -left.mostly.x));
  double right = 9.0;
  EXPECT_EQ(std::sscanf(line_of(outcome.out, "seam front, right").c_str(), "seam front, right: %lf", &right),
            1);
  EXPECT_LT(right, 0.2);
  EXPECT_EQ(line_of(outcome.out, "seam left, right"), "") << "they do not overlap";
  EXPECT_EQ(line_of(outcome.out, "seams:"), "seams: of things far away; what is nearer is apart by parallax");
}

TEST_F(Seams, FarApartAreATrouble) {
  record(recording("left"), pictures_->at("left off by 5"));
  const Outcome off = check({"--set", "seams.distance_m=4"});
  EXPECT_EQ(off.code, 1);
  double texels = 0.0;
  EXPECT_EQ(std::sscanf(line_of(off.err, "seam front, left").c_str(), "seam front, left: %lf", &texels), 1);
  EXPECT_NEAR(texels, 5.0, 0.4);
  EXPECT_THAT(off.err, HasSubstr("expected 2 at most of things 4 m away: see cupola calibrate"));
  EXPECT_THAT(off.out,
              HasSubstr("seams: of things 4 m away; what is nearer or farther is apart by parallax"));
  EXPECT_EQ(line_of(off.err, "seam front, right"), "");

  record(recording("left"), pictures_->at("top"));
  const Outcome other = check();
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(line_of(other.err, "seam front, left"), HasSubstr("nothing alike within 12 texels at"));
  EXPECT_THAT(line_of(other.out, "seam front, left"), HasSubstr("cannot be told"));
}

TEST_F(Seams, AreNotGuessed) {
  const GreyPicture even{kPicture, std::vector<std::uint8_t>(pictures_->at("left").texels.size(), 90)};
  record(recording("left"), even);
  const Outcome plain = check();
  EXPECT_EQ(plain.code, 0) << plain.err;
  EXPECT_THAT(line_of(plain.out, "seam front, left"),
              HasSubstr("cannot be told: of 128 places 128 have too little texture"));

  record(recording("left"), pictures_->at("left"), 20ms);
  const Outcome late = check();
  EXPECT_EQ(late.code, 0) << late.err;
  EXPECT_EQ(line_of(late.out, "seam front, left"),
            "seam front, left: cannot be told: no whole pictures of both within 4 ms");
  EXPECT_THAT(line_of(check({"--set", "sync.tolerance_ms=25"}).out, "seam front, left"),
              HasSubstr("texels apart"));

  record(recording("left"), pictures_->at("left"), 0ms, 240);
  const Outcome cropped = check();
  EXPECT_EQ(cropped.code, 0) << cropped.err;
  EXPECT_EQ(line_of(cropped.out, "seam front, left"),
            "seam front, left: cannot be told: no whole pictures of both within 4 ms");
  EXPECT_THAT(line_of(cropped.out, "seam front, right"), HasSubstr("texels apart"));
}

TEST_F(Seams, WantWhatWasRecorded) {
  const auto refused = [&](std::vector<std::string> words, const std::string& why) {
    const Outcome outcome = call(words);
    EXPECT_EQ(outcome.code, 2) << outcome.out;
    EXPECT_THAT(outcome.err, HasSubstr(why));
  };
  const std::string folder = (folder_ / "r").string();
  refused({"check", "demo", "--replay", folder}, "--replay is for --rig without a show");
  refused({"check", "--replay", folder}, "--replay is for --rig without a show");
  std::filesystem::remove(recording("left"));
  refused({"check", "--rig", (folder_ / "rig.toml").string(), "--replay", folder},
          "left.camera: No such file or directory");
  record(recording("left"), pictures_->at("left"));
  const Outcome other = check({"--set", "view.1.size=[300, 320]"});
  EXPECT_EQ(other.code, 1);
  EXPECT_THAT(other.err,
              HasSubstr("camera left: sends 320 x 320 texels, expected 300 x 320 as the view has"));
}

}  // namespace
}  // namespace cupola
