// What every sound output promises, on the fake one and on ALSA's plugins without a device.
// SPDX-License-Identifier: MIT
#include <gmock/gmock.h>

#include <cstdlib>
#include <cstring>
#include <thread>

#include "hal/sound/alsa_sound.h"
#include "hal/sound/fake_sound.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::HasSubstr;

struct Stage {
  virtual ~Stage() = default;
  virtual SoundOutput& output() = 0;
  virtual Clock& clock() = 0;
  virtual SoundOutput& nowhere() = 0;  // one that cannot be opened
};

struct FakeStage final : Stage {
  FakeClock fake;
  FakeSound sound{fake, {48000, 2}};
  FakeSound gone{fake, {48000, 2}, {.absences = {{0s, 100h}}}};
  SoundOutput& output() override { return sound; }
  Clock& clock() override { return fake; }
  SoundOutput& nowhere() override { return gone; }
};

#ifdef CUPOLA_SOUND
// "null" takes everything at once; "file" writes it down. Neither has a clock of its own.
struct AlsaStage final : Stage {
  TemporaryFolder folder;
  MonotonicClock real;
  std::unique_ptr<SoundOutput> sound, none;
  explicit AlsaStage(const char* device) {
    write_text(folder / "asound.conf",
               "pcm.nothing { type null }\npcm.kept { type file slave.pcm nothing file \"" +
                   (folder / "kept.raw").string() + "\" format raw }\n");
    setenv("ALSA_CONFIG_PATH", (folder / "asound.conf").c_str(), 1);
    sound = make_alsa_sound(device, real);
    none = make_alsa_sound("nowhere", real);
  }
  SoundOutput& output() override { return *sound; }
  Clock& clock() override { return real; }
  SoundOutput& nowhere() override { return *none; }
};
#endif

struct StageMaker {
  const char* name;
  std::unique_ptr<Stage> (*make)();
};
void PrintTo(const StageMaker& maker, std::ostream* out) {
  *out << maker.name;
}

class SoundContract : public testing::TestWithParam<StageMaker> {
 protected:
  std::unique_ptr<Stage> stage_ = GetParam().make();
  SoundOutput& sound_ = stage_->output();
  const std::vector<float> block_ = std::vector<float>(2 * 480, 0.25F);
};

TEST_P(SoundContract, OpensAtWhatIsWanted) {
  EXPECT_EQ(sound_.open({48000, 2}), (SoundMode{48000, 2})) << sound_.trouble();
}

TEST_P(SoundContract, TakesNothingBeforeItIsOpen) {
  EXPECT_FALSE(sound_.write(block_));
  EXPECT_FALSE(sound_.heard());
}

TEST_P(SoundContract, HasHeardNoMoreThanItWasGiven) {
  ASSERT_TRUE(sound_.open({48000, 2}));
  std::int64_t given = 0;
  std::int64_t before = 0;
  for (int turn = 0; turn < 30; ++turn) {
    const std::optional<std::int64_t> taken = sound_.write(block_);
    ASSERT_TRUE(taken) << sound_.trouble();
    EXPECT_GE(*taken, 0);
    EXPECT_LE(*taken, 480);
    given += *taken;
    stage_->clock().sleep_until(stage_->clock().now() + 2ms);
    const std::optional<SoundHeard> heard = sound_.heard();
    ASSERT_TRUE(heard) << sound_.trouble();
    EXPECT_LE(heard->frames, given);
    EXPECT_GE(heard->frames, before) << "it never goes back";
    EXPECT_GE(heard->queued, 0);
    EXPECT_LE(heard->queued, given);
    EXPECT_LE(heard->at, stage_->clock().now());
    before = heard->frames;
  }
  EXPECT_GT(given, 480);
}

TEST_P(SoundContract, CountsAnewWhenItIsOpenedAnew) {
  ASSERT_TRUE(sound_.open({48000, 2}));
  ASSERT_TRUE(sound_.write(block_));
  ASSERT_TRUE(sound_.open({48000, 2}));
  const std::optional<SoundHeard> heard = sound_.heard();
  ASSERT_TRUE(heard);
  EXPECT_EQ(heard->frames, 0);
  EXPECT_EQ(heard->underruns, 0);
}

TEST_P(SoundContract, SaysWhyItCannotBeOpened) {
  EXPECT_FALSE(stage_->nowhere().open({48000, 2}));
  EXPECT_STRNE(stage_->nowhere().trouble(), "");
  EXPECT_FALSE(stage_->nowhere().write(block_));
}

const StageMaker kStages[] = {
    {"fake", [] { return std::unique_ptr<Stage>(std::make_unique<FakeStage>()); }},
#ifdef CUPOLA_SOUND
    {"alsa_null", [] { return std::unique_ptr<Stage>(std::make_unique<AlsaStage>("nothing")); }},
    {"alsa_file", [] { return std::unique_ptr<Stage>(std::make_unique<AlsaStage>("kept")); }},
#endif
};
INSTANTIATE_TEST_SUITE_P(All, SoundContract, testing::ValuesIn(kStages),
                         [](const auto& stage) { return std::string(stage.param.name); });

#ifdef CUPOLA_SOUND
TEST(AlsaSound, WritesTheSamplesThatItWasGivenInTheirOrder) {
  AlsaStage stage("kept");
  ASSERT_TRUE(stage.sound->open({48000, 2})) << stage.sound->trouble();
  std::vector<float> samples(2 * 4800);
  for (std::size_t i = 0; i < samples.size(); ++i) samples[i] = static_cast<float>(i) * 1e-4F;
  ASSERT_EQ(stage.sound->write(samples), 4800);
  stage.sound.reset();
  const std::string kept = read_text(stage.folder / "kept.raw");
  ASSERT_GE(kept.size(), samples.size() * sizeof(float));
  for (std::size_t i = 0; i < samples.size(); ++i) {
    float written = 0.0F;
    std::memcpy(&written, kept.data() + i * sizeof written, sizeof written);
    ASSERT_EQ(written, samples[i]) << i;
  }
}

TEST(AlsaSound, NamesADeviceThatIsNotThere) {
  AlsaStage stage("nothing");
  EXPECT_FALSE(stage.none->open({48000, 2}));
  EXPECT_THAT(stage.none->trouble(), HasSubstr("nowhere: cannot be opened: "));
}
#endif

TEST(FakeSound, RunsDryAndGoesOn) {
  FakeClock clock;
  FakeSound sound(clock, {1000, 1});
  sound.open({1000, 1});
  sound.write(std::vector<float>(100, 1.0F));
  clock.advance(50ms);
  EXPECT_EQ(sound.heard()->frames, 50);
  clock.advance(1s);
  EXPECT_EQ(sound.heard()->frames, 100);
  EXPECT_EQ(sound.heard()->underruns, 1);
  EXPECT_EQ(sound.sounding(), 0.0F);
  sound.write(std::vector<float>(100, 1.0F));
  clock.advance(20ms);
  EXPECT_EQ(sound.heard()->frames, 120);
  EXPECT_EQ(sound.sounding(), 1.0F);
}

}  // namespace
}  // namespace cupola
