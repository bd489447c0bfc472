// OpenCV calibration files: values, pixel centres, and what is refused.
// SPDX-License-Identifier: MIT
#include "pipeline/optics/calibration.h"

#include <gtest/gtest.h>

#include <fstream>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

class Calibration : public testing::Test {
 protected:
  std::filesystem::path write(const std::string& text) {
    std::ofstream(file_) << text;
    return file_;
  }
  std::string refusal(const std::string& text) {
    try {
      View view;
      read_calibration(write(text), view);
    } catch (const InputError& error) {
      return error.what();
    }
    return "";
  }
  static std::string opencv(const std::string& distortion, const std::string& more = "") {
    return "%YAML:1.0\n---\nimage_width: 1280\nimage_height: 720\n" + more +
           "camera_matrix: !!opencv-matrix\n   rows: 3\n   cols: 3\n   dt: d\n"
           "   data: [ 900., 0., 639.5, 0., 910., 359.5, 0., 0., 1. ]\n"
           "distortion_coefficients: !!opencv-matrix\n   rows: 1\n   cols: 5\n   dt: d\n   data: [ " +
           distortion + " ]\n";
  }
  std::filesystem::path file_ =
      std::filesystem::path(testing::TempDir()) /
      (std::string("calibration_") + testing::UnitTest::GetInstance()->current_test_info()->name() + ".yml");
};

TEST_F(Calibration, OpencvFileBecomesAViewWithHalfPixelCentres) {
  View view;
  read_calibration(write(opencv("-0.1, 0.01, 0.001, 0.002, 0.")), view);
  EXPECT_EQ(view.distortion, Distortion::kRadialTangential);
  EXPECT_DOUBLE_EQ(view.focal.x, 900.0 / 1280);
  EXPECT_DOUBLE_EQ(view.focal.y, 910.0 / 720);
  EXPECT_DOUBLE_EQ(view.principal.x, 0.5) << "OpenCV's 639.5 is the middle of 1280 pixels";
  EXPECT_DOUBLE_EQ(view.coefficients[3], 0.002);
  EXPECT_GT(view.limit, 1.0);
}

TEST_F(Calibration, FisheyeModelIsTaken) {
  View view;
  read_calibration(write(opencv("-0.01, 0.001, 0., 0.", "distortion_model: fisheye\n")), view);
  EXPECT_EQ(view.distortion, Distortion::kFisheye);
}

TEST_F(Calibration, ModelsAreTakenUpToTheirPoleOnly) {
  // k4 = -1/4: the radial factor's divisor comes to 0 at r = 2; the corner at 0.8 is well before.
  View view;
  read_calibration(write(opencv("0, 0, 0, 0, 0, -0.25, 0, 0")), view);
  EXPECT_NEAR(view.limit, 2.0, 0.01);
}

TEST_F(Calibration, WrongFilesAreRefusedByName) {
  EXPECT_NE(refusal(opencv("-0.1, 0.01")).find("distortion_coefficients: expected 4, 5 or 8"),
            std::string::npos);
  EXPECT_NE(refusal(opencv(".nan, 0, 0, 0")).find("finite"), std::string::npos);
  EXPECT_NE(refusal(opencv("-3.0, 0, 0, 0, 0")).find("folds"), std::string::npos);
  EXPECT_NE(refusal(opencv("0, 0, 1e300, 0, 0")).find("folds"), std::string::npos);
  EXPECT_NE(refusal(opencv("0, 0, 0, -0.9, 0")).find("p1 and p2"), std::string::npos);
  EXPECT_NE(refusal(opencv("-0.1, 0.01")).find(".yml:1"), std::string::npos) << "the line";
  EXPECT_NE(refusal(std::string(2U << 20U, '#')).find("1 MiB"), std::string::npos);
  EXPECT_NE(refusal("%YAML:1.0\n---\nimage_width: 12\n").find("image_height"), std::string::npos);
  EXPECT_NE(refusal("a: [1, 2\n"), "");
  EXPECT_NE(refusal("just text"), "");
  View view;
  EXPECT_THROW(read_calibration("/no/such/file.yml", view), InputError);
  EXPECT_THROW(read_calibration("/tmp", view), InputError);
}

}  // namespace
}  // namespace cupola
