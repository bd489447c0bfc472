// The dial picks by what trying says, here made up.
// SPDX-License-Identifier: MIT
#include "firmware/dial.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "firmware/dial_trial.h"
#include "firmware/held_budget.h"
#include "firmware/show.h"
#include "pipeline/optics/frame_map.h"
#include "tests/frame/picture_files.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;

// Settings told apart by their alpha, which is their place.
const DialSetting kSettings[] = {{"soft", {.alpha = 0}}, {"sharp", {.alpha = 1}}, {"middle", {.alpha = 2}}};

class MadeUpTrial final : public DialTrial {
 public:
  struct Figures {
    double error, guess_ms, ms;
  };
  explicit MadeUpTrial(std::vector<Figures> figures) : figures_(std::move(figures)) {}
  Sketch sketch(const FilterSettings& filter) override {
    const Figures& at = figures_[static_cast<std::size_t>(filter.alpha)];
    return {at.error, at.guess_ms};
  }
  double milliseconds(const FilterSettings& filter) override {
    measured.emplace_back(kSettings[static_cast<std::size_t>(filter.alpha)].name);
    return figures_[static_cast<std::size_t>(filter.alpha)].ms;
  }
  std::vector<std::string> measured;  // at full size, in order

 private:
  std::vector<Figures> figures_;
};

const std::vector<MadeUpTrial::Figures> kFigures = {{9.0, 2, 3}, {1.0, 7, 10}, {4.0, 4, 6}};

TEST(Dial, PicksTheMostAccurateSettingThatHoldsTheBudget) {
  for (const auto& [budget, name] :
       {std::pair(10.0, "sharp"), std::pair(9.99, "middle"), std::pair(6.0, "middle"),
        std::pair(5.99, "soft"), std::pair(3.0, "soft")}) {
    MadeUpTrial trial(kFigures);
    const DialPick pick = turn_dial(budget, kSettings, trial);
    EXPECT_EQ(pick.picked.name, name) << budget;
    EXPECT_TRUE(pick.holds) << budget;
    EXPECT_LE(pick.picked.milliseconds, budget);
  }
}

TEST(Dial, SaysWhatItGaveUpTheMostAccurateFirst) {
  MadeUpTrial trial(kFigures);
  const DialPick pick = turn_dial(5.0, kSettings, trial);
  EXPECT_THAT(pick.given_up,
              ElementsAre(DialResult{"sharp", 1.0, 10.0, false}, DialResult{"middle", 4.0, 6.0, false}));
  EXPECT_EQ(
      describe(pick, 5.0),
      "budget_ms = 5: soft (3 ms, error 9.00 rms); given up: sharp (10 ms, error 1.00 rms), middle (6 ms, "
      "error 4.00 rms)");
}

TEST(Dial, DoesNotMeasureWhatIsHopelessNorWhatIsLessAccurate) {
  MadeUpTrial low(kFigures);
  EXPECT_THAT(describe(turn_dial(4.0, kSettings, low), 4.0), HasSubstr("sharp (about 7 ms"));
  EXPECT_THAT(low.measured, ElementsAre("middle", "soft"));
  MadeUpTrial high(kFigures);
  turn_dial(20.0, kSettings, high);
  EXPECT_THAT(high.measured, ElementsAre("sharp"));
}

TEST(Dial, TakesTheCheapestAndSaysSoWhereNoneHolds) {
  MadeUpTrial trial(kFigures);
  const DialPick pick = turn_dial(2.0, kSettings, trial);
  EXPECT_EQ(pick.picked, (DialResult{"soft", 9.0, 3.0, false}));
  EXPECT_FALSE(pick.holds);
  EXPECT_THAT(describe(pick, 2.0), HasSubstr("cannot be held: the cheapest filter is soft (3 ms"));
  MadeUpTrial hopeless(kFigures);
  EXPECT_EQ(turn_dial(0.1, kSettings, hopeless).picked.name, "soft");
  EXPECT_THAT(hopeless.measured, ElementsAre("soft")) << "what it costs is said, not guessed";
}

TEST(Dial, BelievesMeasurementsRatherThanGuesses) {
  // The guess for "sharp" is just too high to be tried; "soft" was measured.
  MadeUpTrial trial({{9.0, 2, 3.1}, {1.0, 3.05, 10}, {4.0, 4, 6}});
  const DialPick pick = turn_dial(2.0, kSettings, trial);
  EXPECT_EQ(pick.picked.name, "soft");
  EXPECT_THAT(trial.measured, ElementsAre("soft"));
}

class HeldBudget : public testing::Test {
 protected:
  HeldBudget() {
    rig_ = load_named_rig("omnimax", {});
    set_view_sizes(rig_, std::vector<Size>(rig_.views.size(), Size{64, 64}));
    rig_.budget_ms = 8.0;
  }
  // How often it was measured.
  int hold(Rig rig, Cpu cpu = Cpu::kScalar, int threads = 2, bool deep = false) {
    int measured = 0;
    hold_budget(rig, deep, cpu, threads, folder_.path(), [&] {
      ++measured;
      return pick_;
    });
    EXPECT_EQ(rig.filter.kernel, Kernel::kOptimal);
    return measured;
  }
  Rig rig_;
  TemporaryFolder folder_;
  const DialPick pick_{{"optimal, precise", 2.5, 7.0, false}, true, {{"robidoux", 1.0, 99.0, true}}};
};

TEST_F(HeldBudget, IsMeasuredOnceForARigAMachineAndABudget) {
  EXPECT_EQ(hold(rig_), 1);
  EXPECT_EQ(hold(rig_), 0);
  EXPECT_EQ(hold(rig_, Cpu::kScalar, 3), 1) << "other threads";
  EXPECT_EQ(hold(rig_, Cpu::kSse4), 1) << "another instruction set";
  EXPECT_EQ(hold(rig_, Cpu::kScalar, 2, true), 1) << "faces of 16 bits";
  Rig other = rig_;
  other.budget_ms = 8.5;
  EXPECT_EQ(hold(other), 1);
  other = rig_;
  other.views[0].size.width = 65;
  EXPECT_EQ(hold(other), 1);
  other = rig_;
  other.file = "elsewhere.toml";
  EXPECT_EQ(hold(other), 0) << "the same rig in another place";
  EXPECT_EQ(hold(rig_), 0);
}

TEST_F(HeldBudget, RecallsAllThatWasSaid) {
  keep_pick(folder_.path(), "key", pick_);
  EXPECT_EQ(recalled_pick(folder_.path(), "key"), pick_);
  EXPECT_EQ(recalled_pick(folder_.path(), "another"), std::nullopt);
  EXPECT_EQ(recalled_pick({}, "key"), std::nullopt) << "no cache";
}

TEST_F(HeldBudget, MeasuresAgainWhereTheFileIsDamagedOrOfAnotherProgram) {
  EXPECT_EQ(hold(rig_), 1);
  const std::filesystem::path file = folder_ / folder_.names().front();
  const std::string whole = read_text(file);
  for (const std::string& damaged :
       {std::string(), whole.substr(0, whole.size() / 2), std::string("[]"), std::string("{\"key\": 1}")}) {
    write_text(file, damaged);
    EXPECT_EQ(hold(rig_), 1) << damaged;
    EXPECT_EQ(hold(rig_), 0);
  }
  std::string renamed = whole;
  renamed.replace(renamed.find("\"optimal, precise\""), 18, "\"a filter we had\"");
  write_text(file, renamed);
  EXPECT_EQ(hold(rig_), 1);
}

TEST_F(HeldBudget, LeavesRigsWithoutABudgetAlone) {
  Rig rig = rig_;
  rig.budget_ms.reset();
  rig.filter = paper_preset();
  hold_budget(rig, false, Cpu::kScalar, 1, folder_.path(), [&]() -> DialPick {
    ADD_FAILURE();
    return pick_;
  });
  EXPECT_EQ(rig.filter.alpha, paper_preset().alpha);
  EXPECT_TRUE(folder_.names().empty());
}

// Every reading is a millisecond later than the one before.
class TickingClock final : public Clock {
 public:
  std::chrono::nanoseconds now() noexcept override { return std::chrono::milliseconds(++readings_); }
  void sleep_until(std::chrono::nanoseconds) noexcept override {}
  bool wait(std::span<const int>, std::chrono::nanoseconds) noexcept override { return false; }
  int add_alarm() override { return -1; }
  void set_alarm(int, std::chrono::nanoseconds) noexcept override {}

 private:
  int readings_ = 0;
};

TEST(MachineTrial, OrdersFiltersAsTheTablesOfPerformanceDo) {
  Rig rig = load_named_rig("omnimax", {});
  set_view_sizes(rig, std::vector<Size>(rig.views.size(), Size{1024, 1024}));
  WorkerPool pool(2);
  TickingClock clock;
  for (const bool deep : {true, false}) {
    MachineTrial trial(rig, deep, best_cpu(), pool, nullptr, clock);
    double before = 0.0;
    for (const char* name : {"optimal, precise", "robidoux, precise", "gaussian, precise"}) {
      const auto setting = std::ranges::find(dial_settings(deep), std::string_view(name), &DialSetting::name);
      const DialTrial::Sketch sketch = trial.sketch(setting->filter);
      EXPECT_GT(sketch.error, before + 1.0) << name;
      EXPECT_LT(sketch.error, 25.0);
      EXPECT_NEAR(sketch.milliseconds, 59.0, 1.5)
          << "a small frame took 1 ms, the whole one is 59 times as large";
      before = sketch.error;
      if (deep) break;  // one will do
    }
  }
}

TEST(MachineTrial, ShrinksEveryRigOfOurs) {
  for (const auto& entry :
       std::filesystem::directory_iterator(load_named_rig("omnimax", {}).file.parent_path())) {
    Rig rig = load_rig(entry.path());
    set_view_sizes(rig, std::vector<Size>(rig.views.size(), Size{1024, 768}));
    const Rig small = shrunk(rig, 96);
    EXPECT_LE(std::max(small.frame.size.width, small.frame.size.height), 96) << entry.path();
    const double by = static_cast<double>(small.frame.size.width) / rig.frame.size.width;
    EXPECT_NEAR(small.views[0].size.width, 1024 * by, 1.0) << entry.path();
    const Rig same = shrunk(rig, 100'000);
    EXPECT_EQ(same.frame.size, rig.frame.size);
    if (rig.frame.size.width > 3000) continue;
    WorkerPool pool(1);
    const FrameMap map = map_frame(small, pool);
    const FrameMap whole = map_frame(rig, pool);
    EXPECT_NEAR(static_cast<double>(map.in_image) / static_cast<double>(whole.in_image), by * by,
                0.06 * by * by)
        << entry.path();
  }
}

}  // namespace
}  // namespace cupola
