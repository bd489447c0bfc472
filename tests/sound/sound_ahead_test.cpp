// Sound decoded ahead: in order, around loops, after jumps, past the end.
// SPDX-License-Identifier: MIT
#include "pipeline/sound/sound_ahead.h"

#include <gtest/gtest.h>

#include <chrono>
#include <thread>

#include "tests/sound/fake_track.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;

class SoundAheadTest : public testing::Test {
 protected:
  static std::unique_ptr<SoundAhead> open(std::int64_t length, const SoundPart& part, bool in_step = true,
                                          std::int64_t breaks_at = INT64_MAX) {
    return std::make_unique<SoundAhead>(std::make_unique<FakeTrack>(length, 1, breaks_at), 1, part, 8192,
                                        in_step);
  }
  // The track's frame at place `place`; -1: silence.
  static std::int64_t at(SoundAhead& sound, std::int64_t place) {
    float sample = 0.0F;
    EXPECT_EQ(sound.read(place, {&sample, 1}), 1U);
    return static_cast<std::int64_t>(FakeTrack::frame(sample));
  }
};

TEST_F(SoundAheadTest, GivesFrameAfterFrame) {
  const auto sound = open(1'000'000, {});
  std::vector<float> samples(700);
  for (std::int64_t place = 0; place < 100'000; place += 700) {
    ASSERT_EQ(sound->read(place, samples), 700U);
    for (std::int64_t i = 0; i < 700; ++i)
      ASSERT_EQ(samples[static_cast<std::size_t>(i)], FakeTrack::sample(place + i));
  }
}

TEST_F(SoundAheadTest, JumpsBackAndForth) {
  const auto sound = open(10'000'000, {});
  for (const std::int64_t place : {5, 9'000'000, 100, 4'000'000, 3'990'000, 4'020'000})
    EXPECT_EQ(at(*sound, place), place);
}

TEST_F(SoundAheadTest, PlaysItsPartOverAndOver) {
  const auto sound = open(100'000, {1000, 500, true});
  EXPECT_EQ(at(*sound, 0), 1000);
  EXPECT_EQ(at(*sound, 499), 1499);
  EXPECT_EQ(at(*sound, 500), 1000);
  EXPECT_EQ(at(*sound, 123'456), 1000 + 123'456 % 500);
}

TEST_F(SoundAheadTest, IsSilentAfterItsEndAndSaysWhereThatWas) {
  const auto sound = open(3000, {});
  EXPECT_EQ(at(*sound, 2999), 2999);
  EXPECT_EQ(at(*sound, 3000), -1);
  EXPECT_EQ(at(*sound, 1'000'000), -1);
  EXPECT_EQ(sound->ended(), 3000);
  EXPECT_EQ(at(*sound, 10), 10);
}

TEST_F(SoundAheadTest, ALoopThatIsShorterThanItSaysKeepsItsLength) {
  const auto sound = open(300, {0, 500, true});
  EXPECT_EQ(at(*sound, 299), 299);
  EXPECT_EQ(at(*sound, 300), -1);
  EXPECT_EQ(at(*sound, 500), 0);
}

TEST_F(SoundAheadTest, WhatIsBrokenIsSilentAndNamed) {
  const auto sound = open(10'000, {}, true, 5000);
  EXPECT_EQ(at(*sound, 4999), 4999);
  EXPECT_EQ(at(*sound, 5000), -1);
  EXPECT_EQ(sound->trouble(), "fake.wav: is broken there");
}

TEST_F(SoundAheadTest, DoesNotWaitForItsDecoder) {
  const auto sound = open(100'000'000, {}, false);
  std::vector<float> samples(480);
  std::int64_t place = 0;
  std::size_t got = 0;
  // Whoever asks goes on with the time; the decoder catches up.
  for (int turn = 0; turn < 10'000 && got < 480; ++turn) {
    place += 480;
    if (turn == 0) place = 50'000'000;
    got = sound->read(place, samples);
    if (got > 0) {
      EXPECT_EQ(samples[0], FakeTrack::sample(place));
    }
    std::this_thread::sleep_for(1ms);
  }
  EXPECT_EQ(got, 480U);
}

TEST_F(SoundAheadTest, KeepsALittleOfWhatWasRead) {
  const auto sound = open(1'000'000, {}, false);
  std::vector<float> samples(480);
  std::int64_t place = 0;
  for (int turn = 0; turn < 10'000 && place < 48'000; ++turn) {
    place += static_cast<std::int64_t>(sound->read(place, samples));
    std::this_thread::sleep_for(100us);
  }
  ASSERT_GE(place, 48'000);
  ASSERT_EQ(sound->read(place - 4800, samples), 480U) << "at once: a pause goes on from there";
  EXPECT_EQ(samples[0], FakeTrack::sample(place - 4800));
}

}  // namespace
}  // namespace cupola
