// The hardware tables of rig files: what they give, and what is refused with file, line and key.
// SPDX-License-Identifier: MIT
#include "firmware/rig_devices.h"

#include <gtest/gtest.h>

#include "firmware/show.h"
#include "pipeline/frame/error.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

class RigDevicesTest : public testing::Test {
 protected:
  RigDevices load(const std::string& text, std::vector<std::string> overrides = {}) {
    write_text(folder_ / "rig.toml", text);
    return load_rig_devices(folder_ / "rig.toml", overrides);
  }
  void expect_refused(const std::string& text, const std::string& words) {
    try {
      load(text);
      ADD_FAILURE() << "taken: " << text;
    } catch (const InputError& error) {
      const std::string said = error.what();
      EXPECT_NE(said.find("rig.toml:" + words), std::string::npos)
          << "said: " << said << "\nexpected: " << words;
    }
  }
  TemporaryFolder folder_;
};

const std::string kPanel = R"(tilt_deg = 30
[gpio]
[[gpio.input]]
name = "button-play"
does = "play-pause"
active_low = true
bias = "pull-up"
debounce_ms = 12.5

[[gpio.input]]
chip = "soc"
offset = 7
does = "blackout"

[[gpio.output]]
name = "lamp-enable"
chip = "soc"
is = "lamp"

[[gpio.output]]
name = "camera"
is = "camera-trigger"
active_low = true
)";

TEST_F(RigDevicesTest, ReadsButtonsAndLamps) {
  const GpioSettings gpio = load(kPanel).gpio;
  ASSERT_EQ(gpio.inputs.size(), 2U);
  EXPECT_EQ(gpio.inputs[0].press, PlayerCommand{PlayerAction::kPlayPause});
  const GpioLine& play = gpio.inputs[0].line;
  EXPECT_EQ(play.name, "button-play");
  EXPECT_EQ(play.chip, "");
  EXPECT_EQ(play.offset, -1);
  EXPECT_FALSE(play.output);
  EXPECT_TRUE(play.active_low);
  EXPECT_EQ(play.bias, GpioBias::kPullUp);
  EXPECT_EQ(play.debounce, 12500us);
  EXPECT_EQ(play.debounce_kind, GpioDebounce::kSettled);
  EXPECT_EQ(play.edges, GpioEdges::kToActive);
  EXPECT_EQ(gpio.inputs[1].press, std::nullopt);
  const GpioLine& blackout = gpio.inputs[1].line;
  EXPECT_EQ(blackout.chip, "soc");
  EXPECT_EQ(blackout.offset, 7);
  EXPECT_EQ(blackout.bias, GpioBias::kAsIs);
  EXPECT_EQ(blackout.debounce, 5ms);
  EXPECT_EQ(blackout.debounce_kind, GpioDebounce::kAtOnce);
  EXPECT_EQ(blackout.edges, GpioEdges::kBoth);
  ASSERT_EQ(gpio.outputs.size(), 2U);
  EXPECT_EQ(gpio.outputs[0].is, OutputIs::kLamp);
  EXPECT_EQ(gpio.outputs[0].line.chip, "soc");
  EXPECT_TRUE(gpio.outputs[0].line.output);
  EXPECT_FALSE(gpio.outputs[0].line.active_low);
  EXPECT_EQ(gpio.outputs[1].is, OutputIs::kCameraTrigger);
  EXPECT_TRUE(gpio.outputs[1].line.active_low);
}

TEST_F(RigDevicesTest, ReadsEveryCommandAsAButtonsWithItsArgument) {
  const auto press = [&](const std::string& does) {
    return load("[[gpio.input]]\nname = \"a\"\ndoes = " + does + "\n").gpio.inputs.at(0).press;
  };
  for (const char* word : {"play", "pause", "play-pause", "go", "next", "previous", "fade", "test-pattern",
                           "screenshot", "reload"}) {
    EXPECT_EQ(press('"' + std::string(word) + '"'), parse_command(word, "", {})) << word;
  }
  EXPECT_EQ(press("\"fade\""), (PlayerCommand{PlayerAction::kFade, 2s}));
  EXPECT_EQ(press("\"fade\"\nargument = \"out 3.5\""), (PlayerCommand{PlayerAction::kFadeOut, 3500ms}));
  EXPECT_EQ(press("\"seek\"\nargument = \"0\""), (PlayerCommand{PlayerAction::kSeek, 0s}));
  EXPECT_EQ(press("\"volume\"\nargument = \"+5\""),
            (PlayerCommand{.action = PlayerAction::kVolumeBy, .volume = 5}));
  EXPECT_EQ(press("\"test-pattern\"\nargument = \"grid\""), parse_command("test-pattern", "grid", {}));
  EXPECT_EQ(press("\"cue\"\nargument = \"3\""), (PlayerCommand{.action = PlayerAction::kCue, .cue = 2}));
}

TEST_F(RigDevicesTest, RefusesArgumentsThatACommandDoesNotTake) {
  const std::string input = "[[gpio.input]]\nname = \"a\"\n";
  expect_refused(input + "does = \"fade\"\nargument = \"slowly\"\n",
                 "4: gpio.input.0.argument: fade: expected seconds from 0 to 3600");
  expect_refused(input + "does = \"fade\"\nargument = 2\n",
                 "4: gpio.input.0.argument: expected a text in quotes, not 2");
  expect_refused(input + "does = \"go\"\nargument = \"now\"\n",
                 "4: gpio.input.0.argument: go: expected nothing after it, not \"now\"");
  expect_refused(input + "does = \"volume\"\n",
                 "1: gpio.input.0.argument: missing; volume: expected percent from 0 to 100");
  expect_refused(input + "does = \"blackout\"\nargument = \"on\"\n",
                 "4: gpio.input.0.argument: expected none: the picture is black while the line is active");
  for (const char* cue : {"opening", "0", "10000", "-1", "1.5", "", "1 ", "18446744073709551617"}) {
    expect_refused(input + "does = \"cue\"\nargument = \"" + cue + "\"\n",
                   "4: gpio.input.0.argument: cue: expected the number of a cue, from 1 to 9999");
  }
}

TEST_F(RigDevicesTest, ReadsLockedColoursAndWhetherTheyAreMatched) {
  const std::string camera = "[[camera]]\nview = \"front\"\ndevice = \"a\"\n";
  const RigDevices devices =
      load("[colour]\nmatch = \"slow\"\n" + camera + "gains = [1.1, 1.0, 0.5]\nblack = 4\n");
  EXPECT_TRUE(devices.live.match_colours);
  ASSERT_TRUE(devices.cameras[0].colour);
  EXPECT_EQ(devices.cameras[0].colour->gain, (std::array{1.1, 1.0, 0.5}));
  EXPECT_NEAR(devices.cameras[0].colour->of(0, 4.0), 0.0, 1e-15) << "black is 0 under every gain";
  EXPECT_NEAR(devices.cameras[0].colour->of(2, 24.0), 10.0, 1e-12);
  EXPECT_FALSE(load(camera).cameras[0].colour);
  EXPECT_FALSE(load(camera).live.match_colours);
  expect_refused("[colour]\nmatch = \"fast\"\n", "2: colour.match: expected off or slow");
  expect_refused(camera + "gains = [1, 1, 1.9]\n",
                 "4: camera.0.gains: expected [red, green, blue], each from 0.5 to 1.8");
  expect_refused(camera + "black = 33\n", "4: camera.0.black: expected a number from -32 to 32");
  const std::string rgb = camera + "formats = [\"RGB3\", \"XR24\"]\n";
  expect_refused(rgb + "black = 3\n", "5: camera.0.black: expected a YUV format beside it, as NV12 or YUYV");
  expect_refused("[colour]\nmatch = \"slow\"\n" + rgb,
                 "2: colour.match: expected off, or a YUV format for the camera of view front");
  EXPECT_FALSE(load(rgb).live.match_colours);
  EXPECT_TRUE(
      load("[colour]\nmatch = \"slow\"\n" + camera + "formats = [\"RGB3\", \"NV12\"]\n").live.match_colours);
}

TEST_F(RigDevicesTest, ReadsHowCamerasAreExposedAndAligned) {
  const std::string camera = "[[camera]]\nview = \"front\"\ndevice = \"a\"\n";
  const RigDevices devices =
      load("[exposure]\ndrive = \"together\"\nlongest_us = 8000\n[sync]\nalign = \"slow\"\n" + camera);
  ASSERT_TRUE(devices.live.exposure);
  EXPECT_EQ(devices.live.exposure->longest_us, 8000.0);
  EXPECT_EQ(devices.live.exposure->brightness, 0.45);
  EXPECT_TRUE(devices.live.align);
  const std::vector<CameraControl>& told = devices.cameras[0].setup.controls;
  ASSERT_EQ(told.size(), 3U) << "automatics are switched off, and it begins as it goes on";
  EXPECT_EQ(told[0].name, "auto_exposure");
  EXPECT_EQ(told[1].value, 8000.0);
  EXPECT_EQ(told[2].name, "gain");
  EXPECT_EQ(
      load("[exposure]\ndrive = \"together\"\nmost_gain = 1\n" + camera).cameras[0].setup.controls.size(),
      2U);
  EXPECT_FALSE(load(camera).live.exposure);
  EXPECT_FALSE(load(camera).live.align);
  EXPECT_TRUE(load(camera).cameras[0].setup.controls.empty());
  expect_refused("[exposure]\ndrive = \"apart\"\n", "2: exposure.drive: expected off or together");
  expect_refused("[exposure]\nshortest_us = 900\nlongest_us = 800\n",
                 "3: exposure.longest_us: expected a number from 900 to 1e+06");
  expect_refused(
      "[exposure]\ndrive = \"together\"\nlongest_us = 20000\n" + camera + "rate = 60\n",
      "3: exposure.longest_us: expected at most 16666, a frame's time of the camera of view front");
  expect_refused(
      "[exposure]\ndrive = \"together\"\n" + camera + "[camera.controls]\ngain = 2\n",
      "2: exposure.drive: expected off, or no gain among the controls of the camera of view front");
}

TEST_F(RigDevicesTest, NeedsNoHardwareAtAll) {
  EXPECT_TRUE(load("tilt_deg = 30\n").gpio.empty());
  EXPECT_TRUE(load("[gpio]\n").gpio.empty());
  EXPECT_FALSE(load(kPanel).gpio.empty());
}

TEST_F(RigDevicesTest, LaysOverridesOverTheFile) {
  EXPECT_EQ(load(kPanel, {"gpio.input.0.debounce_ms=3"}).gpio.inputs[0].line.debounce, 3ms);
}

TEST_F(RigDevicesTest, RefusesWhatItDoesNotKnow) {
  const std::string input = "[[gpio.input]]\n";
  const std::string output = "[[gpio.output]]\n";
  expect_refused(input + "name = \"a\"\ndoes = \"blakout\"\n",
                 "3: gpio.input.0.does: expected play, pause, play-pause, go, next, previous, seek, cue, "
                 "blackout, fade,");
  expect_refused(input + "name = \"a\"\n", "1: gpio.input.0.does: missing; expected play, pause");
  expect_refused(input + "does = \"next\"\n", "1: gpio.input.0.name: missing");
  expect_refused(input + "name = \"\"\ndoes = \"next\"\n",
                 "2: gpio.input.0.name: expected the name of a line");
  expect_refused(input + "offset = 3\ndoes = \"next\"\n", "1: gpio.input.0.chip: missing");
  expect_refused(input + "name = \"a\"\nchip = \"c\"\noffset = 3\ndoes = \"next\"\n",
                 "2: gpio.input.0.name: expected either a line's name or chip and offset");
  expect_refused(input + "name = \"a\"\ndoes = \"next\"\nbias = \"up\"\n",
                 "4: gpio.input.0.bias: expected as-is");
  expect_refused(input + "name = \"a\"\ndoes = \"next\"\ndebounce_ms = -1\n",
                 "4: gpio.input.0.debounce_ms: expected a number from 0 to 1000");
  expect_refused(input + "name = \"a\"\ndoes = \"next\"\ndebounce_s = 1\n",
                 "4: gpio.input.0.debounce_s: unknown key; did you mean debounce_ms?");
  expect_refused(output + "name = \"a\"\nis = \"lamp\"\nbias = \"pull-up\"\n",
                 "4: gpio.output.0.bias: unknown key");
  expect_refused(output + "name = \"a\"\nis = \"tally\"\nactive_low = 1\n",
                 "4: gpio.output.0.active_low: expected true or false");
  expect_refused("[gpio]\ninputs = 3\n", "2: gpio.inputs: unknown key; did you mean input?");
  expect_refused("gpio = 3\n", "1: gpio: expected the table [gpio]");
}

TEST_F(RigDevicesTest, RefusesALineThatIsNamedTwice) {
  expect_refused(
      "[[gpio.input]]\nname = \"a\"\ndoes = \"next\"\n[[gpio.output]]\nname = \"a\"\nis = \"lamp\"\n",
      "5: gpio.output.0.name: expected a line of its own; a is taken");
  expect_refused(
      "[[gpio.input]]\nchip = \"c\"\noffset = 1\ndoes = \"next\"\n"
      "[[gpio.input]]\nchip = \"c\"\noffset = 1\ndoes = \"blackout\"\n",
      "7: gpio.input.1.offset: expected a line of its own; chip c, line 1 is taken");
  std::string many;
  for (int i = 0; i <= 64; ++i)
    many += "[[gpio.output]]\nname = \"n" + std::to_string(i) + "\"\nis = \"tally\"\n";
  expect_refused(many, "193: gpio.output.64: expected at most 64 inputs and outputs");
}

TEST_F(RigDevicesTest, ComesWithTheShow) {
  write_text(folder_ / "rig.toml", kPanel + R"([frame]
width = 64
height = 64
[lens]
model = "equidistant"
[[view]]
name = "front"
)");
  write_text(folder_ / "show.toml",
             "rig = \"rig.toml\"\n[[cue]]\nname = \"c\"\nsource = \"generated\"\nworld = \"demo\"\n");
  const std::string lines[] = {"rig.gpio.output.0.is=tally"};
  const Show show = load_show(folder_ / "show.toml", lines);
  EXPECT_EQ(show.devices.gpio.inputs.size(), 2U);
  EXPECT_EQ(show.devices.gpio.outputs[0].is, OutputIs::kTally);
  const std::string wrong[] = {"rig.gpio.output.0.is=tallly"};
  EXPECT_THROW(load_show(folder_ / "show.toml", wrong), InputError);
}

}  // namespace
}  // namespace cupola
