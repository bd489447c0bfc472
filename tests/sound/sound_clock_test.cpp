// The line through what a device says: found soon, and held against jitter.
// SPDX-License-Identifier: MIT
#include "hal/sound/sound_clock.h"

#include <gtest/gtest.h>

#include <cmath>

#include "hal/sound/fake_sound.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

// Plays for `time` and gives the line's largest error in ms after the first minute, and its rate at the end.
struct Followed {
  double worst_ms = 0.0;
  double ppm = 0.0;
};
Followed follow(const FakeSoundFaults& faults, nanoseconds time) {
  FakeClock clock;
  FakeSound sound(clock, {8000, 1}, faults);
  sound.open({8000, 1});
  SoundClock line(8000);
  const std::vector<float> silence(1600);
  Followed followed;
  const nanoseconds begin = clock.now();
  sound.write(silence);
  while (clock.now() - begin < time) {
    clock.advance(10ms);
    const std::optional<SoundHeard> heard = sound.heard();
    line.note(heard->frames, heard->at);
    sound.write(silence);
    const double truth =
        static_cast<double>((clock.now() - begin).count()) * 8e-6 * (1.0 + 1e-6 * faults.ppm);
    // A driver that counts in whole blocks is half a block behind on average: nobody can know.
    const double bias = 0.5 * static_cast<double>(faults.grain - 1);
    if (clock.now() - begin > 1min)
      followed.worst_ms =
          std::max(followed.worst_ms, std::abs(line.heard_at(clock.now()) + bias - truth) / 8.0);
  }
  followed.ppm = line.ppm();
  return followed;
}

TEST(SoundClock, FindsACrystalThatIsOff) {
  for (const double ppm : {-200.0, 0.0, 200.0, 900.0}) {
    const Followed followed = follow({.ppm = ppm}, 2min);
    EXPECT_NEAR(followed.ppm, ppm, 2.0);
    EXPECT_LT(followed.worst_ms, 0.5) << ppm;
  }
}

TEST(SoundClock, HoldsItsLineThroughJitterAndCoarseCounts) {
  const Followed followed = follow({.ppm = 200.0, .grain = 80, .jitter = 3ms}, 5min);
  // Ten milliseconds at a time, asked every ten: the worst that a driver does, a beat of 50 seconds.
  EXPECT_NEAR(followed.ppm, 200.0, 60.0);
  EXPECT_LT(followed.worst_ms, 3.0);
}

TEST(SoundClock, BeginsAnewAtOnceAndKeepsTheRate) {
  SoundClock line(1000);
  for (int i = 0; i < 20'000; ++i) line.note(i * 10 + i / 1000, i * 10ms);
  const double ppm = line.ppm();
  EXPECT_NEAR(ppm, 100.0, 5.0);
  line.begin_anew();
  EXPECT_FALSE(line.knows());
  line.note(7, 500s);
  EXPECT_NEAR(line.heard_at(501s), 1007.1, 0.01);
  EXPECT_NEAR(static_cast<double>((line.time_of(1007.1) - 501s).count()), 0.0, 1e4);
  EXPECT_EQ(line.ppm(), ppm);
}

}  // namespace
}  // namespace cupola
