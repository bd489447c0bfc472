// Decoding ahead: what is shown when, what is counted, and that nobody waits for anybody.
// SPDX-License-Identifier: MIT
#include "pipeline/source/ahead_source.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <chrono>
#include <mutex>
#include <thread>

#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "pipeline/source/file_source.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using testing::ElementsAre;
using testing::HasSubstr;

constexpr Size kSize{40, 36};

// What the decoder does, as its test sees and wants it. All under a mutex.
class Gate {
 public:
  void open(std::int64_t reads) {
    const std::lock_guard lock(mutex_);
    allowed_ = reads;
  }
  void pass(std::int64_t frame) {
    for (;;) {
      {
        const std::lock_guard lock(mutex_);
        if (static_cast<std::int64_t>(read_.size()) < allowed_) {
          read_.push_back(frame);
          return;
        }
      }
      std::this_thread::sleep_for(100us);
    }
  }
  std::vector<std::int64_t> frames_read() const {
    const std::lock_guard lock(mutex_);
    return read_;
  }

 private:
  mutable std::mutex mutex_;
  std::int64_t allowed_ = 1'000'000;
  std::vector<std::int64_t> read_;
};

// Pictures of one level all over.
class Levels final : public PictureStream {
 public:
  Levels(std::int64_t length, Gate& gate, std::vector<std::int64_t> broken = {})
      : length_(length), gate_(gate), broken_(std::move(broken)) {}
  Size size() const override { return kSize; }
  PixelFormat format() const override { return PixelFormat::kRgbPlanar8; }
  std::optional<std::int64_t> length() const override { return length_; }
  std::string name() const override { return "levels"; }
  bool read(std::int64_t frame, RowRange rows, const MutableImage& into, bool) override {
    gate_.pass(frame);
    for (int p = 0; p < 3; ++p)
      for (int y = rows.first; y < rows.last; ++y)
        for (int x = 0; x < kSize.width; ++x) into.samples<std::uint8_t>(p, y)[x] = level(frame);
    if (std::ranges::count(broken_, frame) > 0) throw InputError("file " + std::to_string(frame) + " is bad");
    return true;
  }
  static std::uint8_t level(std::int64_t frame) { return static_cast<std::uint8_t>(frame + 1); }

 private:
  std::int64_t length_;
  Gate& gate_;
  std::vector<std::int64_t> broken_;
};

std::unique_ptr<AheadSource> levels(std::int64_t length, Gate& gate, bool in_step,
                                    std::vector<std::int64_t> broken = {}, std::int64_t first = 0) {
  FaceStreams faces;
  faces.streams.push_back(std::make_unique<Levels>(length, gate, std::move(broken)));
  faces.places.push_back({0, 0, 0, kSize});
  auto source = std::make_unique<AheadSource>(std::move(faces), first, length - first, in_step);
  const NeededRegion all = NeededRegion::all(kSize);
  source->prepare(std::span(&all, 1));
  return source;
}

int level_of(const FaceSet& faces) {
  return sample(faces.faces[0], 1, 3, 35);
}

template <class Condition>
void wait_until(Condition condition) {
  for (int turn = 0; turn < 20'000 && !condition(); ++turn) std::this_thread::sleep_for(1ms);
  ASSERT_TRUE(condition());
}

TEST(AheadSource, HasTheFirstFramesBeforeAnybodyAsks) {
  Gate gate;
  const auto source = levels(100, gate, false, {}, 10);
  wait_until([&] { return source->queue().frames == AheadSource::kAhead; });
  EXPECT_EQ(source->queue().most, AheadSource::kAhead);
  EXPECT_THAT(gate.frames_read(), ElementsAre(10, 11, 12, 13, 14, 15));
  FaceSet faces;
  for (int frame = 10; frame < 16; ++frame) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
    EXPECT_EQ(faces.frame, frame);
    EXPECT_EQ(level_of(faces), Levels::level(frame));
  }
  EXPECT_EQ(source->counts().late, 0);
}

TEST(AheadSource, ShowsEveryFrameInStepWhateverIsAskedFor) {
  Gate gate;
  const auto source = levels(50, gate, true);
  FaceSet faces;
  // In turn, twice, with gaps, far ahead, back, over the end, near the end and around.
  for (const int frame : {0, 1, 1, 2, 4, 7, 40, 41, 3, 4, 49, 0, 1, 48, 2, 30, 29, 28, 5, 0}) {
    const Fetch fetched = source->fetch(frame, faces);
    EXPECT_TRUE(fetched == Fetch::kNew || fetched == Fetch::kUnchanged);
    EXPECT_EQ(faces.frame, frame);
    EXPECT_EQ(level_of(faces), Levels::level(frame)) << frame;
  }
  EXPECT_EQ(source->counts().late + source->counts().sought, 0);
  EXPECT_EQ(source->fetch(50, faces), Fetch::kEnd);
  EXPECT_EQ(source->fetch(-1, faces), Fetch::kEnd);
}

TEST(AheadSource, NeverWaitsButHoldsTheLastFrameAndCountsTheOneThatIsLate) {
  Gate gate;
  gate.open(2);
  const auto source = levels(100, gate, false);
  wait_until([&] { return source->queue().frames == 2; });
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  EXPECT_EQ(source->fetch(1, faces), Fetch::kNew);
  EXPECT_EQ(source->fetch(2, faces), Fetch::kNotYet);
  EXPECT_EQ(source->fetch(2, faces), Fetch::kNotYet);
  EXPECT_EQ(source->fetch(3, faces), Fetch::kNotYet);
  EXPECT_EQ(level_of(faces), Levels::level(1));
  EXPECT_EQ(source->counts().late, 2) << "frames, not times that they were asked for";
  gate.open(3);
  wait_until([&] { return source->queue().frames == 1; });
  EXPECT_EQ(source->fetch(4, faces), Fetch::kNew) << "the newest that is due";
  EXPECT_EQ(faces.frame, 2);
  EXPECT_EQ(level_of(faces), Levels::level(2));
  gate.open(4);
  wait_until([&] { return source->queue().frames == 1; });
  EXPECT_EQ(source->fetch(4, faces), Fetch::kNew);
  EXPECT_EQ(faces.frame, 3) << "begun before 4 was asked for";
  gate.open(1000);
  wait_until([&] { return source->queue().frames == AheadSource::kAhead; });
  EXPECT_EQ(source->fetch(4, faces), Fetch::kNew);
  EXPECT_EQ(faces.frame, 4);
}

TEST(AheadSource, DoesNotDecodeWhatIsPast) {
  Gate gate;
  gate.open(1);
  const auto source = levels(100, gate, false);
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  for (int frame = 1; frame < 60; ++frame) EXPECT_EQ(source->fetch(frame, faces), Fetch::kNotYet);
  gate.open(3);
  wait_until([&] { return gate.frames_read().size() == 3; });
  EXPECT_THAT(gate.frames_read(), ElementsAre(0, 1, 59)) << "1 was begun before";
  gate.open(1000);
}

TEST(AheadSource, ShowsNoFrameFromBeforeAJump) {
  Gate gate;
  const auto source = levels(100, gate, false);
  wait_until([&] { return source->queue().frames == AheadSource::kAhead; });
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kNew);
  wait_until([&] { return source->queue().frames == AheadSource::kAhead; });
  gate.open(7);  // 0 to 6 were read
  EXPECT_EQ(source->fetch(80, faces), Fetch::kNotYet);
  EXPECT_EQ(level_of(faces), Levels::level(0));
  EXPECT_EQ(source->counts().sought, 1);
  gate.open(1000);
  wait_until([&] { return source->queue().frames > 0; });
  EXPECT_EQ(source->fetch(80, faces), Fetch::kNew);
  EXPECT_EQ(level_of(faces), Levels::level(80));
  EXPECT_EQ(source->fetch(20, faces), Fetch::kNotYet) << "back";
  wait_until([&] { return source->queue().frames > 0; });
  EXPECT_EQ(source->fetch(20, faces), Fetch::kNew);
  EXPECT_EQ(level_of(faces), Levels::level(20));
  EXPECT_EQ(source->counts().sought, 2);
  EXPECT_EQ(source->counts().late, 0);
}

TEST(AheadSource, GoesOnWithTheFirstFrameAfterTheLast) {
  Gate gate;
  const auto source = levels(10, gate, false);
  FaceSet faces;
  for (int turn = 0; turn < 35; ++turn) {
    wait_until([&] { return source->queue().frames == AheadSource::kAhead; });
    EXPECT_EQ(source->fetch(turn % 10, faces), Fetch::kNew);
    EXPECT_EQ(level_of(faces), Levels::level(turn % 10));
  }
  EXPECT_EQ(source->counts().late + source->counts().sought, 0);
}

TEST(AheadSource, HasTheFirstFramesAgainWhenItRests) {
  Gate gate;
  const auto source = levels(100, gate, false);
  FaceSet faces;
  for (int frame = 0; frame < 30; ++frame) {
    wait_until([&] { return source->queue().frames > 0; });
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
  }
  source->rest();
  wait_until([&] { return source->queue().frames >= AheadSource::kAhead - 1; });
  EXPECT_EQ(level_of(faces), Levels::level(29)) << "what is lent stands";
  for (int frame = 0; frame < 4; ++frame) {
    EXPECT_EQ(source->fetch(frame, faces), Fetch::kNew);
    EXPECT_EQ(level_of(faces), Levels::level(frame));
  }
  EXPECT_EQ(source->counts().late + source->counts().sought, 0);
}

TEST(AheadSource, HoldsTheLastGoodFrameWhereOneIsBrokenAndNamesIt) {
  for (const bool in_step : {true, false}) {
    Gate gate;
    const auto source = levels(30, gate, in_step, {3, 4, 5, 6, 7, 8, 9, 10, 11, 12, 13, 14, 15});
    FaceSet faces;
    for (int frame = 0; frame < 30; ++frame) {
      wait_until([&] { return source->queue().frames > 0; });
      const bool bad = frame >= 3 && frame <= 15;
      EXPECT_EQ(source->fetch(frame, faces), bad ? Fetch::kFailed : Fetch::kNew) << frame;
      EXPECT_EQ(level_of(faces), Levels::level(bad ? 2 : frame));
      if (bad) {
        EXPECT_EQ(source->trouble(), "file " + std::to_string(frame) + " is bad");
        EXPECT_EQ(source->fetch(frame, faces), Fetch::kFailed) << "and again";
      }
    }
    EXPECT_EQ(source->counts().broken, 13);
    EXPECT_EQ(source->counts().late, 0);
  }
}

TEST(AheadSource, IsBlackUntilTheFirstGoodFrame) {
  Gate gate;
  const auto source = levels(5, gate, true, {0});
  FaceSet faces;
  EXPECT_EQ(source->fetch(0, faces), Fetch::kFailed);
  EXPECT_EQ(level_of(faces), 0);
  EXPECT_EQ(source->fetch(1, faces), Fetch::kNew);
  EXPECT_EQ(level_of(faces), Levels::level(1));
}

// The same frames as the source that decodes in turn, and what changed is never less than the truth.
TEST(AheadSource, GivesWhatFilesInTurnGiveAndSaysWhatChanged) {
  const TemporaryFolder folder;
  const std::vector<std::string> views = {"front", "left"};
  const auto file = [&](const std::string& view, int number) {
    return folder / (view + "_" + std::to_string(number) + ".png");
  };
  constexpr int kFrames = 20;
  for (int number = 1; number <= kFrames; ++number) {
    // Half of a face changes at a time, and some frames are to the byte those before.
    ImageBuffer picture = noise_picture(PixelFormat::kRgbPlanar8, {70, 70}, 1);
    for (int y = 40; y < 70; ++y)
      picture.pixels().samples<std::uint8_t>(0, y)[50] = static_cast<std::uint8_t>(number / 3);
    write_png(file("front", number), picture.pixels());
    write_png(
        file("left", number),
        noise_picture(PixelFormat::kRgbPlanar8, {70, 70}, static_cast<std::uint32_t>(number / 5)).pixels());
  }
  std::string damaged = read_text(file("left", 9));
  write_text(file("left", 9), damaged.substr(0, damaged.size() / 2));
  const auto in_turn = open_sequence((folder / "{view}_%d.png").string(), views);
  AheadSource ahead(std::move(*open_sequence((folder / "{view}_%d.png").string(), views)).streams(), 0,
                    kFrames, true);
  std::vector<NeededRegion> needed(2, NeededRegion::all({70, 70}));
  in_turn->prepare(needed);
  ahead.prepare(needed);
  FaceSet a;
  FaceSet b;
  std::vector<ImageBuffer> before;
  int unchanged = 0;
  for (int turn = 0; turn < 60; ++turn) {
    const int frame = turn < 40 ? turn % kFrames : turn * 7 % kFrames;
    const Fetch by_turn = in_turn->fetch(frame, a);
    const Fetch fetched = ahead.fetch(frame, b);
    EXPECT_EQ(fetched == Fetch::kFailed, by_turn == Fetch::kFailed) << turn;
    unchanged += fetched == Fetch::kUnchanged ? 1 : 0;
    for (std::size_t v = 0; v < 2; ++v) {
      EXPECT_EQ(largest_difference(a.faces[v], b.faces[v]), 0) << turn;
      if (before.size() == 2 && fetched == Fetch::kUnchanged) {
        EXPECT_EQ(largest_difference(before[v].pixels(), b.faces[v]), 0) << turn;
      }
      if (before.size() == 2 && fetched == Fetch::kNew && !b.changed.empty()) {
        for (int y = 0; y < 70; ++y)
          for (int x = 0; x < 70; ++x)
            EXPECT_TRUE(b.changed[v].touches(x, y, x + 1, y + 1) ||
                        sample(before[v], 0, x, y) == sample(b.faces[v], 0, x, y))
                << turn << " " << x;
      }
    }
    before.clear();
    for (std::size_t v = 0; v < 2; ++v) {
      before.emplace_back(PixelFormat::kRgbPlanar8, Size{70, 70});
      convert(b.faces[v], before.back().pixels());
    }
  }
  EXPECT_GT(unchanged, 5);
  EXPECT_GT(ahead.counts().repeated, 10);
  EXPECT_THAT(ahead.trouble(), HasSubstr("left_9.png"));
}

TEST(AheadSource, ReadsOnlyTheRowsThatAreNeeded) {
  const TemporaryFolder folder;
  const ImageBuffer picture = noise_picture(PixelFormat::kRgbPlanar8, {64, 64}, 3);
  write_png(folder / "front_1.png", picture.pixels());
  const std::vector<std::string> views = {"front"};
  AheadSource source(std::move(*open_sequence((folder / "front_%d.png").string(), views)).streams(), 0, 1,
                     true);
  std::vector<NeededRegion> needed = {NeededRegion::none({64, 64})};
  for (int x = 0; x < 64; ++x) needed[0].include(x, 20);
  source.prepare(needed);
  FaceSet faces;
  EXPECT_EQ(source.fetch(0, faces), Fetch::kNew);
  EXPECT_EQ(sample(faces.faces[0], 0, 9, 20), sample(picture, 0, 9, 20));
  EXPECT_EQ(sample(faces.faces[0], 0, 9, 60), 0) << "not stored";
}

}  // namespace
}  // namespace cupola
