// Shows with sound, played by the program into ALSA's plugins that need no sound card.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <cmath>
#include <csignal>
#include <cstring>
#include <nlohmann/json.hpp>

#include "tests/firmware/program.h"

namespace cupola {
namespace {

using nlohmann::json;
using testing::HasSubstr;

void put(std::string& bytes, std::uint32_t number, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(number >> (8 * i));
}

class Sound : public ProgramTest {
 protected:
  Sound() {
    write_text(folder_ / "asound.conf",
               "pcm.nothing { type null }\npcm.kept { type file slave.pcm nothing file \"" +
                   path("kept.raw") + "\" format raw }\n");
    std::string wav = "RIFF";
    constexpr std::uint32_t kFrames = 48000;
    put(wav, 36 + 2 * kFrames, 4);
    wav += "WAVEfmt ";
    put(wav, 16, 4);
    put(wav, 1 + (1U << 16), 4);
    put(wav, 48000, 4);
    put(wav, 96000, 4);
    put(wav, 2 + (16U << 16), 4);
    wav += "data";
    put(wav, 2 * kFrames, 4);
    for (std::uint32_t i = 0; i < kFrames; ++i) put(wav, 16384, 2);
    write_text(folder_ / "half.wav", wav);
    write_show("half.wav");
  }
  void write_show(const std::string& sound) const {
    write_text(folder_ / "show.toml", R"(rig = "rig.toml"
[sound]
device = "kept"
[[cue]]
name = "only"
source = "generated"
world = "demo"
face_size = [48, 48]
duration_s = 0.6
sound = ")" + sound + "\"\n");
  }
  Outcome play(std::vector<std::string> more = {}) const {
    more.insert(more.begin(),
                {"play", path("show.toml"), "--display", "fake", "--stats", path("stats.json")});
    return call(more, {.environment = {"ALSA_CONFIG_PATH=" + path("asound.conf")}});
  }
  json stats() const { return json::parse(read_text(path("stats.json"))); }
};

TEST_F(Sound, IsPlayedWithTheCue) {
  const Outcome outcome = play();
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_EQ(outcome.err, "");
  EXPECT_TRUE(stats()["sound"]["working"]);
  EXPECT_EQ(stats()["sound"]["rate_hz"], 48000);
  EXPECT_EQ(stats()["heap_allocations"], 0);
  const std::string kept = read_text(folder_ / "kept.raw");
  int at_half = 0;
  for (std::size_t i = 0; i + 4 <= kept.size(); i += 4) {
    float sample = 0.0F;
    std::memcpy(&sample, kept.data() + i, sizeof sample);
    ASSERT_LE(std::abs(sample), 0.51F);
    at_half += std::abs(sample - 0.3535F) < 0.001F || std::abs(sample - 0.5F) < 0.001F ? 1 : 0;
  }
  EXPECT_GT(at_half, 2 * 10000) << "a fifth of a second at least, on a loaded machine";
}

TEST_F(Sound, ThatIsNotThereIsNamedAndTheShowGoesOn) {
  write_show("none.wav");
  const Outcome outcome = play();
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("cupola: cue only: " + path("none.wav") +
                                     ": No such file or directory; expected a sound; it is silent"));
  EXPECT_GT(stats()["frames_presented"], 10);
}

TEST_F(Sound, WithoutADeviceTheShowGoesOn) {
  const Outcome outcome = play({"--set", "sound.device=nowhere"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_THAT(outcome.err, HasSubstr("cupola: the sound device is away: nowhere: cannot be opened: "));
  EXPECT_FALSE(stats()["sound"]["working"]);
  EXPECT_GT(stats()["frames_presented"], 10);
}

TEST_F(Sound, IsCheckedBeforeTheShow) {
  const Outcome good = call({"check", path("show.toml")});
  EXPECT_NE(good.code, 2) << good.err;
  EXPECT_THAT(good.out, HasSubstr("cue only: sound of 1 channels, 1.0 s\n"));
  write_show("show.toml");
  const Outcome bad = call({"check", path("show.toml")});
  EXPECT_EQ(bad.code, 2);
  EXPECT_THAT(bad.err, HasSubstr("cue only: " + path("show.toml") + ": not a sound that can be read"));
}

TEST_F(Sound, IsLeftOutWhereNoTimePasses) {
  EXPECT_EQ(play({"--fast-forward"}).code, 0);
  EXPECT_FALSE(std::filesystem::exists(path("kept.raw")));
}

TEST_F(Sound, AWrongKeyIsNamedWithItsLine) {
  expect_refusal({"check", path("show.toml"), "--set", "sound.volume=101"}, 2,
                 {"sound.volume", "expected a whole number from 0 to 100"});
  expect_refusal({"check", path("show.toml"), "--set", "cue.0.sound=own"}, 2,
                 {"cue.0.sound", "expected a file: only a video has a sound of its own"});
}

}  // namespace
}  // namespace cupola
