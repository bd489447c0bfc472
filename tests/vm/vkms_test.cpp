// Runs inside a virtual machine (tests/vm/guest): the KMS display on the kernel's virtual screen.
// SPDX-License-Identifier: MIT
#include <fcntl.h>
#include <poll.h>
#include <pthread.h>
#include <sys/mman.h>
#include <unistd.h>
#include <xf86drm.h>

#include <algorithm>
#include <array>
#include <atomic>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <optional>
#include <stdexcept>
#include <string>
#include <thread>

#include <gmock/gmock.h>

#include "hal/display/kms_display.h"
#include "pipeline/frame/yuv_colour.h"
#include "tests/hal/display_contract.h"
#include "tests/vm/vkms_screen.h"

namespace cupola {
namespace {

using std::chrono::nanoseconds;
using testing::HasSubstr;

// Time stands still while the machine computes; elsewhere it shares a processor with who knows whom.
bool virtual_time() {
  std::ifstream file("/proc/cmdline");
  const std::string line{std::istreambuf_iterator<char>(file), {}};
  return line.find("time-travel=inf-cpu") != std::string::npos;
}

nanoseconds slack_of_this_machine() {
  return virtual_time() ? 0s : 1s;
}

KmsSettings settings_of(const char* mode, KmsMemoryKind memory = KmsMemoryKind::kDumb) {
  return {"Virtual-1", *parse_kms_mode(mode), {}, memory};
}

template <KmsMemoryKind kMemory>
struct VkmsStage final : DisplayStage {
  VkmsStage(int width, int height) : display_(time, settings_of("1024x768", kMemory), width, height) {}
  ~VkmsStage() override { plug_vkms(true); }
  Clock& clock() override { return time; }
  Display& display() override { return display_; }
  bool unplug() override {
    plug_vkms(false);
    return true;
  }
  void plug() override { plug_vkms(true); }
  nanoseconds slack() const override { return slack_of_this_machine(); }
  MonotonicClock time;
  KmsDisplay display_;
};
INSTANTIATE_TEST_SUITE_P(
    Vkms, DisplayContract,
    testing::Values(DisplayStageMaker{"Dumb", make_display_stage<VkmsStage<KmsMemoryKind::kDumb>>},
                    DisplayStageMaker{"Gbm", make_display_stage<VkmsStage<KmsMemoryKind::kGbm>>}),
    [](const auto& maker) { return std::string(maker.param.name); });

class Vkms : public testing::Test {
 protected:
  ~Vkms() override { plug_vkms(true); }
  // A pattern that differs from frame to frame, everywhere.
  static std::uint32_t colour(int x, int y, int frame) {
    return 0xff000000U | static_cast<std::uint32_t>((x * 7 + frame * 31) & 255) << 16U |
           static_cast<std::uint32_t>((y * 5 + frame) & 255) << 8U |
           static_cast<std::uint32_t>((x ^ y) & 255);
  }
  static void draw(Display& display, int frame) {
    const DisplayBuffer buffer = display.back_buffer();
    ASSERT_NE(buffer.data, nullptr);
    for (int y = 0; y < buffer.height; ++y) {
      for (int x = 0; x < buffer.width; ++x) {
        const std::uint32_t word = colour(x, y, frame);
        std::memcpy(buffer.data + y * buffer.stride + 4 * x, &word, 4);
      }
    }
  }
  // The frame in the middle of the mode, black around it.
  static void expect_on_screen(int frame, int width, int height, int mode_width, int mode_height) {
    const std::vector<std::uint32_t> screen = vkms_screen(mode_width, mode_height);
    const int left = (mode_width - width) / 4 * 2;
    const int top = (mode_height - height) / 4 * 2;
    int wrong = 0;
    for (int y = 0; y < mode_height; ++y) {
      for (int x = 0; x < mode_width; ++x) {
        const bool inside = x >= left && x < left + width && y >= top && y < top + height;
        const std::uint32_t expected = inside ? colour(x - left, y - top, frame) & 0xffffffU : 0U;
        const std::uint32_t shown = screen[static_cast<std::size_t>(y * mode_width + x)] & 0xffffffU;
        wrong += shown == expected ? 0 : 1;
      }
    }
    EXPECT_EQ(wrong, 0) << "pixels of frame " << frame;
  }
  // Until it is shown, at most 100 times; how many times it was not.
  static int repeat_until_shown(Display& display) {
    int times = 0;
    while (times < 100 && display.repeat(nanoseconds(0)).result != Present::kShown) ++times;
    return times;
  }
  // On a machine that stutters a flip may come too late to count.
  static int most_unshown() { return virtual_time() ? 1 : 50; }

  MonotonicClock clock_;
};

TEST_F(Vkms, IsListedWithItsModes) {
  const std::vector<KmsCard> cards = list_kms_cards();
  ASSERT_EQ(cards.size(), 1U);
  EXPECT_EQ(cards[0].driver, "vkms");
  EXPECT_EQ(cards[0].trouble, "");
  ASSERT_EQ(cards[0].connectors.size(), 1U) << "the write-back connector is none of ours";
  EXPECT_EQ(cards[0].connectors[0].name, "Virtual-1");
  EXPECT_TRUE(cards[0].connectors[0].connected);
  EXPECT_GT(cards[0].connectors[0].modes.size(), 5U);
}

TEST_F(Vkms, FlipsSixHundredTimesOnTheModesRaster) {
  KmsDisplay display(clock_, settings_of("1024x768@60"), 1024, 768);
  EXPECT_NEAR(1e9 / static_cast<double>(display.period().count()), 60.0, 0.01);
  constexpr int kFlips = 600;
  nanoseconds first{0};
  nanoseconds before{0};
  nanoseconds off{0};  // the raster, at most
  std::int64_t missed = 0;
  int shown = 0;
  for (int i = 0; i < kFlips; ++i) {
    const DisplayBuffer buffer = display.back_buffer();
    ASSERT_EQ(buffer.age, i < 2 ? 0 : 2);
    const Presented presented = display.present(before + display.period());
    ASSERT_EQ(presented.result, Present::kShown) << display.trouble();
    ++shown;
    if (i == 0) first = presented.flipped_at;
    before = presented.flipped_at;
    const nanoseconds time = before - first;
    const std::int64_t periods = (time + display.period() / 2) / display.period();
    off = std::max(off, std::chrono::abs(time - periods * display.period()));
    missed = periods - i;
  }
  EXPECT_LE(off, 2us) << "the kernel states times in microseconds";
  EXPECT_GE(missed, 0);
  if (virtual_time()) {
    EXPECT_EQ(missed, 0);
  }
  std::printf("vkms: %d flips, %.3f us off the raster of 60 Hz at most, %d periods without one\n", shown,
              1e-3 * static_cast<double>(off.count()), static_cast<int>(missed));
}

TEST_F(Vkms, ScansOutTheVeryPixelsItWasGiven) {
  for (const KmsMemoryKind memory : {KmsMemoryKind::kDumb, KmsMemoryKind::kGbm}) {
    KmsDisplay display(clock_, settings_of("1024x768", memory), 1024, 768);
    for (int frame = 0; frame < 5; ++frame) {
      draw(display, frame);
      ASSERT_EQ(display.present(clock_.now()).result, Present::kShown) << display.trouble();
      expect_on_screen(frame, 1024, 768, 1024, 768);
    }
  }
}

// Of an NV12 frame: another one in every pixel, and in each direction of colour.
std::uint8_t luma_of(int x, int y, int frame) {
  return static_cast<std::uint8_t>(x * 7 + y * 5 + frame * 31);
}
std::uint8_t chroma_of(int x, int y, int channel, int frame) {
  return static_cast<std::uint8_t>(channel == 0 ? x * 3 + frame : y * 3 + x + frame);
}

void draw_nv12(Display& display, int frame) {
  const DisplayBuffer buffer = display.back_nv12();
  ASSERT_NE(buffer.data, nullptr);
  ASSERT_NE(buffer.chroma, nullptr);
  for (int y = 0; y < buffer.height; ++y) {
    for (int x = 0; x < buffer.width; ++x)
      buffer.data[y * buffer.stride + x] = std::byte{luma_of(x, y, frame)};
  }
  for (int y = 0; y < (buffer.height + 1) / 2; ++y) {
    for (int x = 0; x < (buffer.width + 1) / 2 * 2; ++x) {
      buffer.chroma[y * buffer.stride + x] = std::byte{chroma_of(x / 2, y, x % 2, frame)};
    }
  }
}

// Within the rounding of the driver's conversion; black around it.
void expect_nv12_on_screen(YuvColour colour, int frame, int width, int height) {
  const std::vector<std::uint32_t> screen = vkms_screen(1024, 768);
  const int left = (1024 - width) / 4 * 2;
  const int top = (768 - height) / 4 * 2;
  double worst = 0.0;
  long lit_outside = 0;
  for (int y = 0; y < 768; ++y) {
    for (int x = 0; x < 1024; ++x) {
      const std::uint32_t shown = screen[static_cast<std::size_t>(y * 1024 + x)] & 0xffffffU;
      const int there_x = x - left;
      const int there_y = y - top;
      // The last chroma sample may stand for a pixel beyond the frame, which is dark but not quite black.
      if (there_x < 0 || there_x > width || there_y < 0 || there_y > height)
        lit_outside += shown != 0 ? 1 : 0;
      if (there_x < 0 || there_x >= width || there_y < 0 || there_y >= height) continue;
      const auto rgb =
          rgb_of(colour, luma_of(there_x, there_y, frame), chroma_of(there_x / 2, there_y / 2, 0, frame),
                 chroma_of(there_x / 2, there_y / 2, 1, frame));
      for (std::size_t c = 0; c < 3; ++c) {
        const double value = shown >> (16 - 8 * c) & 255U;
        worst = std::max(worst, std::abs(value - std::clamp(rgb[c], 0.0, 255.0)));
      }
    }
  }
  EXPECT_LE(worst, 0.51) << "of frame " << frame;
  EXPECT_EQ(lit_outside, 0);
}

TEST_F(Vkms, ScansOutNv12OfTheColourThatItIsTold) {
  for (const bool bt709 : {false, true}) {
    for (const bool full : {false, true}) {
      const YuvColour colour{bt709 ? YuvMatrix::kBt709 : YuvMatrix::kBt601,
                             full ? YuvRange::kFull : YuvRange::kLimited};
      KmsDisplay display(clock_, settings_of("1024x768"), 1024, 768);
      ASSERT_TRUE(display.prepare_nv12({bt709, full}));
      for (int frame = 0; frame < 3; ++frame) {
        draw_nv12(display, frame);
        ASSERT_EQ(display.present(clock_.now()).result, Present::kShown) << display.trouble();
        expect_nv12_on_screen(colour, frame, 1024, 768);
      }
    }
  }
}

TEST_F(Vkms, PutsSmallerFramesOfNv12InTheMiddleOfBlack) {
  for (const auto& [width, height] : {std::pair{301, 203}, {1024, 2}, {1, 768}}) {
    KmsDisplay display(clock_, settings_of("1024x768"), width, height);
    ASSERT_TRUE(display.prepare_nv12({}));
    draw_nv12(display, 1);
    ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
    expect_nv12_on_screen({}, 1, width, height);
  }
}

TEST_F(Vkms, ShowsFramesOfBothFormatsByTurnsAndKnowsTheirAge) {
  KmsDisplay display(clock_, settings_of("1024x768"), 64, 48);
  ASSERT_TRUE(display.prepare_nv12({}));
  const std::array<bool, 12> nv12 = {false, false, true,  true,  true,  true,
                                     false, true,  false, false, false, true};
  for (std::size_t i = 0; i < nv12.size(); ++i) {
    const int frame = static_cast<int>(i);
    const int age = (nv12[i] ? display.back_nv12() : display.back_buffer()).age;
    if (age > 0) {
      EXPECT_EQ(nv12[i - static_cast<std::size_t>(age)], nv12[i]) << "it holds a frame of the same format";
    }
    if (nv12[i]) {
      draw_nv12(display, frame);
    } else {
      draw(display, frame);
    }
    ASSERT_EQ(display.present(clock_.now()).result, Present::kShown) << display.trouble();
    if (nv12[i]) {
      expect_nv12_on_screen({}, frame, 64, 48);
    } else {
      expect_on_screen(frame, 64, 48, 1024, 768);
    }
  }
  draw_nv12(display, 20);
  ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
  plug_vkms(false);
  ASSERT_EQ(display.repeat(clock_.now()).result, Present::kAway);
  plug_vkms(true);
  EXPECT_LE(repeat_until_shown(display), most_unshown());
  expect_nv12_on_screen({}, 20, 64, 48);
}

TEST_F(Vkms, TakesNoNv12ThroughGbm) {
  KmsDisplay display(clock_, settings_of("1024x768", KmsMemoryKind::kGbm), 64, 48);
  EXPECT_FALSE(display.prepare_nv12({}));
  EXPECT_EQ(display.back_nv12().data, nullptr);
  draw(display, 1);
  ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
  expect_on_screen(1, 64, 48, 1024, 768);
}

TEST_F(Vkms, PutsSmallerFramesInTheMiddleOfBlack) {
  for (const auto& [width, height] : {std::pair{301, 203}, {1024, 2}, {1, 768}}) {
    KmsDisplay display(clock_, settings_of("1024x768"), width, height);
    for (int frame = 0; frame < 3; ++frame) {
      draw(display, frame);
      ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
      expect_on_screen(frame, width, height, 1024, 768);
    }
  }
}

TEST_F(Vkms, TakesTheModeThatIsAskedFor) {
  for (const auto& [mode, width, height] :
       {std::tuple{"640x480@60", 640, 480}, {"1920x1080", 1920, 1080}, {"800x600@60", 800, 600}}) {
    KmsDisplay display(clock_, settings_of(mode), 600, 400);
    EXPECT_THAT(display.description(), HasSubstr("Virtual-1 at " + std::to_string(width) + "x"));
    draw(display, 1);
    ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
    expect_on_screen(1, 600, 400, width, height);
  }
}

TEST_F(Vkms, RefusesInWordsWhatItCannotShow) {
  const auto refusal = [&](const KmsSettings& settings, int width, int height) -> std::string {
    try {
      const KmsDisplay display(clock_, settings, width, height);
    } catch (const std::runtime_error& error) {
      return error.what();
    }
    return "opened";
  };
  EXPECT_THAT(refusal(settings_of("1024x768"), 1025, 768),
              HasSubstr("is larger than the mode 1024x768@60.00"));
  EXPECT_THAT(refusal(settings_of("1234x567@60"), 64, 48), HasSubstr("no mode 1234x567@60; it has "));
  EXPECT_THAT(refusal({"HDMI-A-7", {}, {}, {}}, 64, 48),
              HasSubstr("no connector HDMI-A-7; /dev/dri/card0 has Virtual-1"));
  EXPECT_THAT(refusal({{}, {}, "/dev/dri/card9", {}}, 64, 48), HasSubstr("kms: "));
  plug_vkms(false);
  EXPECT_THAT(refusal({{}, {}, {}, {}}, 64, 48), HasSubstr("Virtual-1 (nothing plugged in)"));
}

TEST_F(Vkms, WaitsForAProjectorThatIsNamedAndSwitchedOnLater) {
  plug_vkms(false);
  KmsDisplay display(clock_, settings_of("1024x768"), 320, 200);
  for (int frame = 0; frame < 5; ++frame) {
    draw(display, frame);
    ASSERT_EQ(display.present(clock_.now()).result, Present::kAway);
    EXPECT_STREQ(display.trouble(), "Virtual-1 has nothing plugged in");
  }
  plug_vkms(true);
  EXPECT_LE(repeat_until_shown(display), most_unshown());
  expect_on_screen(4, 320, 200, 1024, 768);
  draw(display, 5);
  ASSERT_EQ(display.present(clock_.now()).result, Present::kShown);
  expect_on_screen(5, 320, 200, 1024, 768);
}

TEST_F(Vkms, ComesBackAHundredTimesWithinTwoPeriods) {
  KmsDisplay display(clock_, settings_of("1024x768@60"), 64, 48);
  int frame = 0;
  for (int loss = 0; loss < 100; ++loss) {
    draw(display, ++frame);
    ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown) << loss;
    plug_vkms(false);
    for (int i = 0; i < 1 + loss % 4; ++i) {
      draw(display, ++frame);
      ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kAway) << loss;
    }
    clock_.sleep_until(clock_.now() + display.period() * (loss % 10) / 10);
    const nanoseconds back = clock_.now();
    plug_vkms(true);
    EXPECT_LE(repeat_until_shown(display), most_unshown()) << loss;
    EXPECT_LE(clock_.now(), back + 2 * display.period() + slack_of_this_machine()) << loss;
  }
  expect_on_screen(frame, 64, 48, 1024, 768);
}

TEST_F(Vkms, IsAwayWhileAnotherProgramHasTheScreenAndThenSetsItsModeAgain) {
  KmsDisplay display(clock_, settings_of("1024x768"), 64, 48);
  draw(display, 0);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown);
  ASSERT_EQ(drmDropMaster(vkms_descriptor()), 0);
  {
    KmsDisplay other(clock_, settings_of("800x600"), 800, 600);
    draw(other, 1);
    ASSERT_EQ(other.present(nanoseconds(0)).result, Present::kShown);
    for (int frame = 2; frame < 6; ++frame) {
      draw(display, frame);
      const nanoseconds before = clock_.now();
      ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kAway);
      EXPECT_STREQ(display.trouble(), "Virtual-1 belongs to another program for now");
      EXPECT_LE(clock_.now(), before + 2 * display.period() + slack_of_this_machine());
    }
  }
  EXPECT_LE(repeat_until_shown(display), most_unshown());
  expect_on_screen(5, 64, 48, 1024, 768);
}

// Takes the card's events before anybody else sees them.
class EventThief {
 public:
  EventThief() : thread_([this] { steal(); }) {
    sched_param priority{1};
    pthread_setschedparam(thread_.native_handle(), SCHED_FIFO, &priority);
  }
  ~EventThief() {
    stop_ = true;
    thread_.join();
  }
  EventThief(const EventThief&) = delete;
  EventThief& operator=(const EventThief&) = delete;

 private:
  void steal() const {
    pollfd card{vkms_descriptor(), POLLIN, 0};
    while (!stop_) {
      char events[256];
      if (poll(&card, 1, 1) > 0 && read(card.fd, events, sizeof events) < 0) continue;
    }
  }
  std::atomic<bool> stop_{false};
  std::thread thread_;
};

TEST_F(Vkms, WaitsThreePeriodsForAFlipAndRecoversFromOneThatIsNotAnnounced) {
  KmsDisplay display(clock_, settings_of("1024x768"), 64, 48);
  draw(display, 0);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown);
  int frame = 0;
  {
    const EventThief thief;
    clock_.sleep_until(clock_.now() + 50ms);
    for (int i = 0; i < 5; ++i) {
      draw(display, ++frame);
      const nanoseconds before = clock_.now();
      ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kAway);
      EXPECT_STREQ(display.trouble(), "Virtual-1 does not flip");
      EXPECT_LE(clock_.now(), before + 5 * display.period() + slack_of_this_machine());
    }
  }
  EXPECT_LE(repeat_until_shown(display), 65) << "a second";
  expect_on_screen(frame, 64, 48, 1024, 768);
  draw(display, ++frame);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown);
  expect_on_screen(frame, 64, 48, 1024, 768);
}

TEST_F(Vkms, IsAwayForAFlipWhileSomebodyElsesIsOnItsWay) {
  KmsDisplay display(clock_, settings_of("1024x768"), 64, 48);
  draw(display, 0);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown);
  const auto memory = dumb_memory(vkms_descriptor());
  KmsBuffer theirs;
  ASSERT_EQ(memory->make(theirs, 1024, 768), 0);
  ASSERT_EQ(flip_vkms(theirs.framebuffer), 0);
  draw(display, 1);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kAway);
  EXPECT_THAT(display.trouble(), HasSubstr("flip: Device or resource busy"));
  const nanoseconds before = clock_.now();
  const Presented shown = display.repeat(nanoseconds(0));
  ASSERT_EQ(shown.result, Present::kShown);
  EXPECT_GT(shown.flipped_at, before) << "our flip's time, not theirs";
  expect_on_screen(1, 64, 48, 1024, 768);
  memory->free(theirs);
}

TEST_F(Vkms, IsLostWhenTheCardIsGone) {
  KmsDisplay display(clock_, settings_of("1024x768"), 64, 48);
  draw(display, 0);
  ASSERT_EQ(display.present(nanoseconds(0)).result, Present::kShown);
  EXPECT_NE(std::system("modprobe -r vkms 2>/dev/null"), 0) << "the kernel keeps drivers that are in use";
  ASSERT_EQ(display.repeat(nanoseconds(0)).result, Present::kShown);
  const int nothing = open("/dev/null", O_RDWR);
  ASSERT_GE(dup2(nothing, vkms_descriptor()), 0);  // as good as pulling it out
  close(nothing);
  for (int i = 0; i < 3; ++i) {
    EXPECT_EQ(display.repeat(nanoseconds(0)).result, Present::kLost);
    EXPECT_STRNE(display.trouble(), "");
  }
}

}  // namespace
}  // namespace cupola
