// Sets of frames by timestamp: four cameras in step, late, gone and back.
// SPDX-License-Identifier: MIT
#include "pipeline/source/rig_sync.h"

#include <functional>
#include <map>
#include <random>
#include <vector>

#include <gtest/gtest.h>

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;
using State = SyncedFace::State;

constexpr nanoseconds kPeriod = 16'666'667ns;
constexpr nanoseconds kDelay = 5ms;  // from a frame's timestamp to its arrival

CameraFrame frame_at(nanoseconds at, std::uint64_t sequence) {
  CameraFrame frame;
  frame.sequence = sequence;
  frame.captured_at = at;
  frame.buffer = static_cast<int>(sequence % 8);
  return frame;
}

// Four cameras whose frames arrive as the script says, and a screen that asks every period.
class Rig {
 public:
  explicit Rig(const SyncSettings& settings = {}) : sync(4, settings) {}

  // Frame `sequence` of camera `c`: when it was taken, and when it comes; false: never.
  std::function<bool(std::size_t c, std::uint64_t sequence, nanoseconds& at, nanoseconds& comes)> script =
      [](std::size_t, std::uint64_t, nanoseconds&, nanoseconds&) { return true; };

  void run(int flips, const std::function<void(int flip, nanoseconds now)>& see) {
    struct Arrival {
      std::size_t camera;
      CameraFrame frame;
    };
    std::multimap<nanoseconds, Arrival> arrivals;
    for (std::size_t c = 0; c < 4; ++c) {
      for (std::uint64_t n = 0; n < static_cast<std::uint64_t>(flips); ++n) {
        nanoseconds at = static_cast<std::int64_t>(n) * kPeriod;
        nanoseconds comes = at + kDelay;
        if (script(c, n, at, comes)) arrivals.insert({comes, {c, frame_at(at, n)}});
      }
    }
    auto next = arrivals.begin();
    for (int flip = 0; flip < flips; ++flip) {
      const nanoseconds now = flip * kPeriod + 12ms;
      for (; next != arrivals.end() && next->first <= now; ++next) {
        sync.offer(next->second.camera, next->second.frame, next->first);
        ++held;
      }
      sync.choose(now);
      while (sync.spent()) --held;
      EXPECT_GE(held, 0);
      EXPECT_LE(held, 4 * static_cast<int>(RigSync::kHeld));
      see(flip, now);
    }
  }

  RigSync sync;
  int held = 0;
};

TEST(RigSync, ShowsEverySetOfCamerasInStep) {
  Rig rig;
  rig.run(100, [&](int flip, nanoseconds) {
    for (const SyncedFace& face : rig.sync.faces()) {
      EXPECT_EQ(face.state, State::kInStep);
      EXPECT_EQ(face.frame.sequence, static_cast<std::uint64_t>(flip));
    }
    EXPECT_EQ(rig.sync.captured_at(), flip * kPeriod);
  });
  EXPECT_EQ(rig.sync.counts().sets, 100U);
  EXPECT_EQ(rig.sync.counts().whole, 100U);
  EXPECT_EQ(rig.sync.counts().passed_over, 0U);
}

TEST(RigSync, PutsNearestFramesTogetherWhateverTheirNumbers) {
  Rig rig;
  std::mt19937 random(1);
  std::uniform_int_distribution<int> jitter(-1'000'000, 1'000'000);
  rig.script = [&](std::size_t c, std::uint64_t, nanoseconds& at, nanoseconds& comes) {
    at += nanoseconds(jitter(random)) + static_cast<int>(c) * 400us;
    comes = at + kDelay;
    return true;
  };
  rig.run(500, [&](int, nanoseconds) {
    const auto& faces = rig.sync.faces();
    for (const SyncedFace& face : faces) {
      ASSERT_EQ(face.state, State::kInStep);
      EXPECT_LE(std::chrono::abs(face.frame.captured_at - faces[0].frame.captured_at), 4ms);
      EXPECT_EQ(face.frame.sequence, faces[0].frame.sequence);
    }
  });
  EXPECT_GE(rig.sync.counts().whole, 499U);
}

TEST(RigSync, LeavesTheOthersUndisturbedWhenOneFallsSilent) {
  for (std::size_t silent = 0; silent < 4; ++silent) {
    Rig rig;
    rig.script = [&](std::size_t c, std::uint64_t sequence, nanoseconds&, nanoseconds&) {
      return c != silent || sequence < 20 || sequence >= 80;
    };
    rig.run(120, [&](int flip, nanoseconds now) {
      for (std::size_t c = 0; c < 4; ++c) {
        const SyncedFace& face = rig.sync.faces()[c];
        if (c != silent || flip < 20 || flip >= 80) {
          EXPECT_EQ(face.state, State::kInStep) << c << ' ' << flip;
          EXPECT_EQ(face.frame.sequence, static_cast<std::uint64_t>(flip)) << c;
        } else if (now - 19 * kPeriod <= 500ms) {
          EXPECT_EQ(face.state, State::kLate) << flip;
          EXPECT_EQ(face.frame.sequence, 19U);
        } else {
          EXPECT_EQ(face.state, State::kSlate) << flip;
        }
      }
    });
  }
}

TEST(RigSync, WaitsForACameraThatIsOnlyJustLateButNotForOneThatWas) {
  Rig rig;
  // Camera 3 comes just after the screen has asked, from frame 10 on.
  rig.script = [](std::size_t c, std::uint64_t sequence, nanoseconds&, nanoseconds& comes) {
    if (c == 3 && sequence >= 10) comes += 8ms;
    return true;
  };
  std::vector<int> torn;
  rig.run(100, [&](int flip, nanoseconds) {
    for (const SyncedFace& face : rig.sync.faces()) {
      if (face.state != State::kInStep) torn.push_back(flip);
    }
  });
  EXPECT_LE(torn.size(), 1U) << "then all run one frame later, in step";
  EXPECT_EQ(rig.sync.faces()[0].frame.sequence, 98U);
}

TEST(RigSync, PassesOverFramesOfAFasterCamera) {
  Rig rig;
  rig.script = [](std::size_t c, std::uint64_t sequence, nanoseconds& at, nanoseconds& comes) {
    if (c == 1) at = static_cast<std::int64_t>(sequence) * kPeriod / 2;
    comes = at + kDelay;
    return true;
  };
  rig.run(40, [&](int flip, nanoseconds) {
    if (flip > 19) return;  // its script is over
    for (const SyncedFace& face : rig.sync.faces()) EXPECT_EQ(face.state, State::kInStep);
  });
  EXPECT_GT(rig.sync.counts().passed_over, 15U);
}

TEST(RigSync, GivesBackEveryFrameThatItWasLent) {
  Rig rig;
  std::mt19937 random(2);
  rig.script = [&](std::size_t, std::uint64_t, nanoseconds& at, nanoseconds& comes) {
    at += nanoseconds(static_cast<std::int64_t>(random() % 20'000'000));
    comes = at + nanoseconds(static_cast<std::int64_t>(random() % 40'000'000));
    return random() % 10 != 0;
  };
  rig.run(2000, [](int, nanoseconds) {});
  rig.sync.choose(1h);
  while (rig.sync.spent()) --rig.held;
  for (const SyncedFace& face : rig.sync.faces()) EXPECT_EQ(face.state, State::kSlate);
  EXPECT_EQ(rig.held, 0);
}

TEST(RigSync, ShowsTheCopyOfALostCamerasLastFrameForThePatience) {
  Rig rig;
  rig.run(10, [](int, nanoseconds) {});
  const nanoseconds now = 9 * kPeriod + 12ms;
  const CameraFrame kept = rig.sync.faces()[2].frame;
  rig.sync.lose(2, &kept);
  rig.sync.lose(1, nullptr);
  EXPECT_TRUE(rig.sync.choose(now));
  EXPECT_EQ(rig.sync.faces()[1].state, State::kSlate) << "no copy was kept";
  EXPECT_EQ(rig.sync.faces()[2].state, State::kLate);
  EXPECT_FALSE(rig.sync.choose(9 * kPeriod + 500ms));
  EXPECT_EQ(rig.sync.faces()[2].state, State::kLate);
  EXPECT_TRUE(rig.sync.choose(9 * kPeriod + 501ms));
  EXPECT_EQ(rig.sync.faces()[2].state, State::kSlate);
}

TEST(RigSync, MeasuresOffsetAndDriftOfEveryClock) {
  Rig rig;
  std::mt19937 random(3);
  std::uniform_int_distribution<int> jitter(-100'000, 100'000);
  rig.script = [&](std::size_t c, std::uint64_t, nanoseconds& at, nanoseconds& comes) {
    const double ppm = 20.0 * static_cast<double>(c);
    at += static_cast<int>(c) * 500us +
          nanoseconds(static_cast<std::int64_t>(1e-6 * ppm * static_cast<double>(at.count()))) +
          nanoseconds(jitter(random));
    comes = at + kDelay;
    return true;
  };
  constexpr int kFlips = 1200;
  rig.run(kFlips, [](int, nanoseconds) {});
  for (std::size_t c = 1; c < 4; ++c) {
    const SyncOffset measured = rig.sync.offset(c);
    const double ppm = 20.0 * static_cast<double>(c);
    const double expected =
        500e3 * static_cast<double>(c) + 1e-6 * ppm * kFlips * static_cast<double>(kPeriod.count());
    EXPECT_NEAR(static_cast<double>(measured.offset.count()), expected, 60e3) << c;
    EXPECT_NEAR(measured.drift_ppm, ppm, 60.0) << c;
  }
}

}  // namespace
}  // namespace cupola
