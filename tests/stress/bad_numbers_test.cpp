// Every number of a rig, lens, filter or calibration file replaced by hostile ones: a clear error, or a rig
// whose pixels are finite.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <fstream>

#include "pipeline/frame/error.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/footprint.h"
#include "tests/stress/random_rigs.h"

namespace cupola {
namespace {

constexpr const char* kHostile[] = {"nan",
                                    "-nan",
                                    "inf",
                                    "-inf",
                                    "0",
                                    "-0.0",
                                    "-1",
                                    "1e-300",
                                    "5e-324",
                                    "1e-9",
                                    "1e300",
                                    "1e308",
                                    "-1e308",
                                    "1e9",
                                    "1000000000",
                                    "0.0000001",
                                    "9223372036854775807",
                                    "65535",
                                    "65536",
                                    "1e-6",
                                    "1e6",
                                    "179.999999",
                                    "360",
                                    "0.1",
                                    "true",
                                    "\"1\""};

// One key a line, so that lines can be named; "@" stands for the number.
struct Template {
  const char* key;  // as the message has it
  const char* text;
};

constexpr const char* kViews =
    "[[view]]\nname = \"front\"\nsize = [32, 32]\n[[view]]\nname = \"left\"\nsize = [32, 32]\n";

const Template kRigs[] = {
    {"tilt_deg", "tilt_deg = @\n[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n"},
    {"frame.width", "[frame]\nwidth = @\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n"},
    {"frame.height", "[frame]\nheight = @\nwidth = 30\n[lens]\nmodel = \"omnimax-c430\"\n"},
    {"frame.radius", "[frame]\nwidth = 40\nheight = 30\nradius = @\n[lens]\nmodel = \"omnimax-c430\"\n"},
    {"frame.center", "[frame]\nwidth = 40\nheight = 30\ncenter = [@, 3]\n[lens]\nmodel = \"omnimax-c430\"\n"},
    {"frame.fov_deg", "[frame]\nmodel = \"mercator\"\nwidth = 40\nheight = 30\nfov_deg = @\n"},
    {"frame.fov_deg", "[frame]\nmodel = \"cylindrical\"\nwidth = 40\nheight = 3000\nfov_deg = @\n"},
    {"frame.fov_deg", "[frame]\nmodel = \"equirectangular\"\nwidth = 40\nheight = 30\nfov_deg = @\n"},
    {"lens.fov_deg", "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"equidistant\"\nfov_deg = @\n"},
    {"lens.fov_deg", "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"equisolid\"\nfov_deg = @\n"},
    {"lens.fov_deg", "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"stereographic\"\nfov_deg = @\n"},
    {"lens.fov_deg", "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"orthographic\"\nfov_deg = @\n"},
    {"lens.coefficients",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"polynomial\"\ncoefficients = [0, @]\n"},
    {"lens.coefficients",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"polynomial\"\ncoefficients = [0, 1.5, 0, @]\n"},
    {"lens.coefficients",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"opencv-fisheye\"\ncoefficients = [@, 0.01]\n"},
    {"lens.coefficients",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"opencv-fisheye\"\nfov_deg = 1\ncoefficients = [0, "
     "0, 0, @]\n"},
    {"filter.alpha",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[filter]\nalpha = @\n"},
    {"filter.radius",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[filter]\nradius = @\n"},
    {"filter.noise",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[filter]\nkernel = \"optimal\"\n"
     "noise = @\n"},
    {"filter.radius",
     "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[filter]\nkernel = \"jinc\"\n"
     "radius = @\n"},
    {"filter.rec", "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[filter]\nrec = @\n"},
};

// Keys of a view, beside the name "odd" and a frame.
const Template kViewLines[] = {{"view.0.fov_deg", "fov_deg = @\n"},
                               {"view.0.fov_y_deg", "fov_deg = 90\nfov_y_deg = @\n"},
                               {"view.0.size", "size = [@, 32]\n"},
                               {"view.0.position_m", "position_m = [0.1, @, 0]\n"},
                               {"view.0.forward", "forward = [@, 0, -1]\nup = [0, 1, 0]\n"},
                               {"view.0.up", "forward = [0, 0, -1]\nup = [0, 1, @]\n"}};

class HostileNumbers : public testing::Test {
 protected:
  HostileNumbers() {
    folder_ = std::filesystem::path(testing::TempDir()) /
              (std::string("hostile_") + testing::UnitTest::GetInstance()->current_test_info()->name());
    std::filesystem::create_directories(folder_);
  }
  ~HostileNumbers() override { std::filesystem::remove_all(folder_); }

  static std::string with(std::string text, const std::string& number) {
    return text.replace(text.find('@'), 1, number);
  }

  // Loads it; an error must name the file, the line where `line` wants it, and the key.
  void expect_sound(const std::string& text, const std::string& key, int line) {
    const std::filesystem::path file = folder_ / "rig.toml";
    std::ofstream(file) << text;
    Rig rig;
    try {
      rig = load_rig(file);
    } catch (const InputError& error) {
      const std::string message = error.what();
      EXPECT_TRUE(message.find(folder_.string()) == 0 && message.find(key) != std::string::npos) << message;
      const std::string place = "rig.toml:" + std::to_string(line) + ": ";
      EXPECT_TRUE(line == 0 || message.find(place) != std::string::npos) << message << "\nexpected " << place;
      ++refused_;
      return;
    }
    ++taken_;
    expect_finite(rig);
  }

  static void expect_finite(Rig& rig) {
    for (View& view : rig.views) {
      if (view.size.width == 0 || view.size.width > 64) view.size.width = 32;
      if (view.size.height == 0 || view.size.height > 64) view.size.height = 32;
    }
    test::Dice dice(1);
    std::vector<Tap> taps;
    static const test::NoiseFaces noise(1);
    const std::vector<Image> faces = noise.faces(rig);
    const FootprintGatherer gatherer(rig);
    const bool gaussian = rig.filter.kernel == Kernel::kGaussian;
    const bool least_squares = rig.filter.kernel == Kernel::kOptimal;  // milliseconds a pixel
    const double least = gaussian ? 0.0 : -255.001;
    const double most = gaussian ? 255.001 : 510.001;
    for (int i = 0; i < (least_squares ? 4 : 60); ++i) {
      const test::Pixel pixel{dice.whole(0, rig.frame.size.width - 1),
                              dice.whole(0, rig.frame.size.height - 1)};
      DirectionAndSlope looking;
      if (ray(rig.frame, {pixel.x + 0.5, pixel.y + 0.5}, looking)) {
        ASSERT_TRUE(std::isfinite(glm::dot(looking.direction, Vec3{1, 1, 1})));
        ASSERT_NEAR(glm::length(looking.direction), 1.0, 1e-9);
      }
      const Footprint found = gatherer.gather(pixel.x, pixel.y, taps);
      ASSERT_EQ(found == Footprint::kCovered, !taps.empty());
      double sum = 0.0;
      for (const Tap& tap : taps) sum += tap.weight;
      ASSERT_NEAR(sum, taps.empty() ? 0.0 : 1.0, 1e-9);
      for (const double value : ewa_exact(rig, faces, pixel.x, pixel.y))
        ASSERT_TRUE(value >= least && value <= most);
    }
  }

  std::filesystem::path folder_;
  int refused_ = 0;
  int taken_ = 0;
};

TEST_F(HostileNumbers, OfRigsLensesAndFilters) {
  for (const Template& rig : kRigs) {
    for (const char* number : kHostile) {
      SCOPED_TRACE(std::string(rig.key) + " = " + number);
      const std::string text = rig.text;
      const auto line =
          1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(text.find('@')), '\n');
      // frame.layout, lens.model and the like may be what is refused instead; the table is named.
      const std::string table = std::string(rig.key).substr(0, std::string(rig.key).find('.'));
      expect_sound(with(text, number) + kViews, table, static_cast<int>(line));
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(refused_, 200);
  EXPECT_GT(taken_, 50);
}

TEST_F(HostileNumbers, OfViews) {
  for (const Template& view : kViewLines) {
    for (const char* number : kHostile) {
      SCOPED_TRACE(std::string(view.key) + " = " + number);
      const std::string head =
          "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[[view]]\nname = \"front\"\n";
      expect_sound(head + with(view.text, number), "view.0.", 0);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(refused_, 50);
}

TEST_F(HostileNumbers, OfCalibrations) {
  const char* kTexts[] = {
      "image_width: @\nimage_height: 480\ncamera_matrix: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [0, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: [@, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [0, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: [500, 0, @, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [0, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [@, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [0, 0, @, 0]\n",
      "image_width: 640\nimage_height: 480\ncamera_matrix: [500, 0, 320, 0, 500, 240, 0, 0, 1]\n"
      "distortion_coefficients: [0, 0, 0, 0, 0, @, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ndistortion_model: fisheye\n"
      "camera_matrix: [@, 0, 320, 0, 500, 240, 0, 0, 1]\ndistortion_coefficients: [0, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ndistortion_model: fisheye\n"
      "camera_matrix: [300, 0, 320, 0, 300, @, 0, 0, 1]\ndistortion_coefficients: [0, 0, 0, 0]\n",
      "image_width: 640\nimage_height: 480\ndistortion_model: fisheye\n"
      "camera_matrix: [300, 0, 320, 0, 300, 240, 0, 0, 1]\ndistortion_coefficients: [0, @, 0, 0]\n"};
  for (const char* text : kTexts) {
    for (const std::string number : kHostile) {
      const std::string as_yaml = number.find("nan") != std::string::npos ? ".nan"
                                  : number.find("inf") != std::string::npos
                                      ? "." + number.substr(number.size() - 3)
                                      : number;
      SCOPED_TRACE(with(text, as_yaml));
      std::ofstream(folder_ / "camera.yml") << with(text, as_yaml);
      expect_sound(
          "[frame]\nwidth = 40\nheight = 30\n[lens]\nmodel = \"omnimax-c430\"\n[[view]]\nname = \"front\"\n"
          "calibration = \"camera.yml\"\n",
          "camera.yml", 0);
      if (HasFatalFailure()) return;
    }
  }
  EXPECT_GT(refused_, 80);
}

}  // namespace
}  // namespace cupola
