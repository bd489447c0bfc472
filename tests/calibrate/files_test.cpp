// Calibration's files: the folder of shots, lenses, and the rig with other views.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include "pipeline/calibrate/calibration_file.h"
#include "pipeline/calibrate/rig_text.h"
#include "pipeline/calibrate/shot_folder.h"
#include "pipeline/frame/error.h"
#include "pipeline/optics/calibration.h"
#include "pipeline/optics/rig.h"
#include "tests/calibrate/simulated_rig.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

template <class Call>
std::string refusal(Call&& call) {
  try {
    call();
  } catch (const InputError& error) {
    return error.what();
  }
  return "";
}

TEST(ShotFolder, ListsPicturesByViewAndShotAndRefusesStrangers) {
  const TemporaryFolder folder;
  const std::vector<std::string> views = {"front", "left"};
  const auto list = [&] { return list_shots(folder.path(), views); };
  EXPECT_THAT(refusal([&] { list_shots(folder / "none", views); }),
              HasSubstr("expected a folder of pictures"));
  EXPECT_THAT(refusal(list), HasSubstr("expected pictures, as in"));
  for (const char* name : {"front", "left"}) std::filesystem::create_directory(folder / name);
  for (const char* name :
       {"front/0002.png", "front/0001.png", "left/0002.jpg", "left/0010.png", "left/.hidden"})
    write_text(folder / name, "");
  const ShotFolder found = list();
  EXPECT_THAT(found.shots, ElementsAre("0001", "0002", "0010"));
  ASSERT_EQ(found.pictures.size(), 4U);
  EXPECT_EQ(found.pictures[2].camera, 1);
  EXPECT_EQ(found.pictures[2].shot, 1) << "the same moment as front/0002.png";
  EXPECT_EQ(found.pictures[2].file, folder / "left/0002.jpg");
  write_text(folder / "left/0002.png", "");
  EXPECT_THAT(refusal(list), HasSubstr("expected one picture a shot"));
  std::filesystem::remove(folder / "left/0002.png");
  std::filesystem::create_directory(folder / "frnt");
  EXPECT_THAT(refusal(list), HasSubstr("did you mean front?"));
}

TEST(CalibrationFile, IsReadBackAsTheViewItWas) {
  const TemporaryFolder folder;
  SimulatedCamera camera = simulated_cameras({600, 480})[2];
  for (const bool fisheye : {false, true}) {
    if (fisheye) {
      camera.view.distortion = Distortion::kFisheye;
      camera.view.coefficients = {0.01, -0.002, 0.001, -0.0001};
    }
    write_text(folder / "lens.yml", calibration_text(camera.view, 0.07));
    View read;
    read_calibration(folder / "lens.yml", read);
    EXPECT_EQ(read.distortion, camera.view.distortion);
    EXPECT_NEAR(read.focal.x, camera.view.focal.x, 1e-11);
    EXPECT_NEAR(read.focal.y, camera.view.focal.y, 1e-11);
    EXPECT_NEAR(read.principal.x, camera.view.principal.x, 1e-11);
    EXPECT_NEAR(read.principal.y, camera.view.principal.y, 1e-11);
    for (std::size_t i = 0; i < 8; ++i)
      EXPECT_NEAR(read.coefficients[i], camera.view.coefficients[i], 1e-11) << i;
  }
}

class RigText : public testing::Test {
 protected:
  RigText() {
    lens_ = calibration_text(simulated_cameras({600, 600})[0].view, 0.1);
    write_text(folder_ / "lens.yml", lens_);
  }
  std::string rewrite(const std::string& text, const std::vector<ViewKeys>& keys) {
    write_text(folder_ / "rig.toml", text);
    const Rig rig = load_rig(folder_ / "rig.toml");
    return rewrite_views(text, "rig.toml", keys, rig.world_from_lens);
  }
  Rig load(const std::string& text) {
    write_text(folder_ / "new.toml", text);
    return load_rig(folder_ / "new.toml");
  }
  TemporaryFolder folder_;
  std::string lens_;
  const std::string head_ = "[frame]\nwidth = 64\nheight = 64\n[lens]\nmodel = \"equidistant\"\n";
};

TEST_F(RigText, ReplacesTheViewsKeysAndKeepsAllElse) {
  const Vec3 forward = glm::normalize(Vec3{-1.0, 0.1, 0.02});
  const Vec3 up = glm::normalize(glm::cross(glm::cross(forward, Vec3{0, 1, 0}), forward));
  const std::string text =
      head_ +
      "# our dome\n[[view]]\nname = \"front\"  # the anchor\nfov_deg = 100\n\n"
      "[[view]]\nforward = [-1,\n  0, 0]\nup = [0, 1, 0]\nsize = [600, 600]\nname = \"aside\"\n";
  const std::string result =
      rewrite(text, {{"lens.yml", {}, {}, {}}, {"lens.yml", forward, up, Vec3{0.1, -0.02, 0.03}}});
  EXPECT_THAT(
      result,
      HasSubstr("# our dome\n[[view]]\nname = \"front\"  # the anchor\ncalibration = \"lens.yml\"\n"));
  EXPECT_THAT(result, testing::Not(HasSubstr("fov_deg")));
  const Rig rig = load(result);
  EXPECT_EQ(rig.views[0].forward, (Vec3{0, 0, -1}));
  EXPECT_LT(glm::length(rig.views[1].forward - forward), 1e-8);
  EXPECT_LT(glm::length(rig.views[1].up - up), 1e-8);
  EXPECT_LT(glm::length(rig.views[1].position_m - Vec3{0.1, -0.02, 0.03}), 1e-9);
  EXPECT_EQ(rig.views[1].size, (Size{600, 600}));
  EXPECT_EQ(rig.views[1].distortion, Distortion::kRadialTangential);
}

TEST_F(RigText, TurnsPosesOfViewsThatAreLevelWithTheHorizon) {
  const std::string text = "views = \"world\"\ntilt_deg = 30\n" + head_ + "[[view]]\nname = \"front\"\n";
  const Vec3 forward = glm::normalize(Vec3{0.1, -0.5, -0.8});
  const Vec3 up = glm::normalize(glm::cross(glm::cross(forward, Vec3{0, 1, 0}), forward));
  const Rig rig = load(rewrite(text, {{"lens.yml", forward, up, Vec3{0.1, -0.02, 0.03}}}));
  EXPECT_LT(glm::length(rig.views[0].forward - forward), 1e-8);
  EXPECT_LT(glm::length(rig.views[0].up - up), 1e-8);
  EXPECT_LT(glm::length(rig.views[0].position_m - Vec3{0.1, -0.02, 0.03}), 1e-4) << "a tenth of a millimetre";
}

TEST_F(RigText, RefusesViewsWhoseKeysShareALine) {
  const std::string text = "view = [{name = \"front\", fov_deg = 90}]\n" + head_;
  EXPECT_THAT(refusal([&] {
                rewrite(text, {{"lens.yml", {}, {}, {}}});
              }),
              HasSubstr("rig.toml:1: view.0: expected the views as tables [[view]]"));
}

}  // namespace
}  // namespace cupola
