// Sound files through FFmpeg's libraries: the samples that were put in, wherever one begins to read.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/sound_track.h"

#include <gmock/gmock.h>

#include <cmath>
#include <numbers>

#include "pipeline/frame/error.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::HasSubstr;

void put(std::string& bytes, std::uint32_t number, int count) {
  for (int i = 0; i < count; ++i) bytes += static_cast<char>(number >> (8 * i));
}

// 16 bits; sample s of all of them is `value(s)`.
template <class Value>
std::string wav(int rate, int channels, int frames, Value value) {
  std::string bytes = "RIFF";
  const auto data = static_cast<std::uint32_t>(2 * channels * frames);
  put(bytes, 36 + data, 4);
  bytes += "WAVEfmt ";
  put(bytes, 16, 4);
  put(bytes, 1, 2);
  put(bytes, static_cast<std::uint32_t>(channels), 2);
  put(bytes, static_cast<std::uint32_t>(rate), 4);
  put(bytes, static_cast<std::uint32_t>(2 * rate * channels), 4);
  put(bytes, static_cast<std::uint32_t>(2 * channels), 2);
  put(bytes, 16, 2);
  bytes += "data";
  put(bytes, data, 4);
  for (int i = 0; i < frames * channels; ++i)
    put(bytes, static_cast<std::uint32_t>(static_cast<std::int16_t>(value(i))) & 0xffffU, 2);
  return bytes;
}

class SoundTrackTest : public testing::Test {
 protected:
  std::string refusal(const std::string& name) const {
    try {
      open_sound(folder_ / name, 48000, 2);
    } catch (const InputError& error) {
      return error.what();
    }
    return "taken";
  }
  TemporaryFolder folder_;
};

TEST_F(SoundTrackTest, GivesEverySampleWhereverItBeginsToRead) {
  write_text(folder_ / "count.wav", wav(48000, 2, 48000, [](int i) { return i % 30011; }));
  const auto track = open_sound(folder_ / "count.wav", 48000, 2);
  EXPECT_EQ(track->length(), 48000);
  EXPECT_EQ(track->file_channels(), 2);
  std::vector<float> samples(2 * 777);
  for (const std::int64_t first : {0, 777, 1554, 40000, 3, 20000, 47000, 12345}) {
    ASSERT_EQ(track->read(first, samples), 777U) << first;
    for (std::int64_t i = 0; i < 2 * 777; ++i)
      ASSERT_EQ(samples[static_cast<std::size_t>(i)], static_cast<float>((2 * first + i) % 30011) / 32768.0F);
  }
  EXPECT_EQ(track->read(47900, samples), 100U);
  EXPECT_EQ(track->read(48000, samples), 0U);
  EXPECT_EQ(track->read(99999, samples), 0U);
  EXPECT_EQ(track->read(0, samples), 777U);
  EXPECT_EQ(track->damaged(), 0);
}

TEST_F(SoundTrackTest, ResamplesToTheRateAndKeepsTheTime) {
  const auto sine = [](double seconds) { return std::sin(2.0 * std::numbers::pi * 500.0 * seconds); };
  write_text(folder_ / "sine.wav",
             wav(44100, 1, 88200, [&](int i) { return std::lround(20000.0 * sine(i / 44100.0)); }));
  const auto track = open_sound(folder_ / "sine.wav", 48000, 1);
  EXPECT_EQ(track->length(), 96000);
  std::vector<float> samples(2000);
  for (const std::int64_t first : {10000, 60000, 30000}) {
    ASSERT_EQ(track->read(first, samples), 2000U);
    for (std::size_t i = 0; i < samples.size(); ++i)
      ASSERT_NEAR(samples[i],
                  20000.0 / 32768.0 * sine((static_cast<double>(first) + static_cast<double>(i)) / 48000.0),
                  2e-2)
          << first + static_cast<std::int64_t>(i);
  }
}

TEST_F(SoundTrackTest, MixesToTheLoudspeakersThereAre) {
  write_text(folder_ / "mono.wav", wav(48000, 1, 4800, [](int) { return 8192; }));
  const auto track = open_sound(folder_ / "mono.wav", 48000, 2);
  std::vector<float> samples(200);
  ASSERT_EQ(track->read(100, samples), 100U);
  EXPECT_EQ(samples[0], samples[1]);
  EXPECT_GT(samples[0], 0.1F);
}

TEST_F(SoundTrackTest, RefusesWhatIsNoSoundAndSaysWhy) {
  write_text(folder_ / "text.wav", "this is no sound at all, whatever its name says");
  write_text(folder_ / "empty.wav", "");
  write_text(folder_ / "head.wav", wav(48000, 2, 0, [](int) { return 0; }));
  write_text(folder_ / "list.m3u", "#EXTM3U\nhttp://localhost/sound.wav\n");
  EXPECT_THAT(refusal("none.wav"), HasSubstr("none.wav: No such file or directory; expected a sound"));
  EXPECT_THAT(refusal("text.wav"), HasSubstr("text.wav: not a sound that can be read"));
  EXPECT_THAT(refusal("empty.wav"), HasSubstr("empty.wav"));
  EXPECT_THAT(refusal("head.wav"), HasSubstr("head.wav"));
  EXPECT_THAT(refusal("list.m3u"), HasSubstr("not a sound that can be read"));
}

TEST_F(SoundTrackTest, AFileThatWasCutShortEndsEarly) {
  std::string bytes = wav(48000, 2, 48000, [](int i) { return i % 30011; });
  bytes.resize(bytes.size() / 2);
  write_text(folder_ / "cut.wav", bytes);
  const auto track = open_sound(folder_ / "cut.wav", 48000, 2);
  std::vector<float> samples(2 * 48000);
  const std::size_t got = track->read(0, samples);
  EXPECT_GT(got, 23000U);
  EXPECT_LT(got, 24000U + 1U);
}

}  // namespace
}  // namespace cupola
