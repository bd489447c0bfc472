// A day of a show on the fake clock, with the frame loop that is shipped: nothing late, nothing kept.
// SPDX-License-Identifier: MIT
#include <gtest/gtest.h>
#include <malloc.h>

#include <cstdio>
#include <filesystem>

#include "firmware/frame_loop.h"
#include "firmware/heap_count.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "tests/hal/sanitized.h"

namespace cupola {
namespace {

using namespace std::chrono_literals;
using std::chrono::nanoseconds;

constexpr int kHours = test::kSanitized ? 1 : 24;

Show small_show() {
  const std::string lines[] = {
      "rig.frame.width=16", "rig.frame.height=12", "rig.frame.center=[8, 6]", "rig.frame.radius=8",
      R"(cue=[{name="a", source="generated", world="demo", face_size=[8, 8], rate=24, duration_s=20},)"
      R"({name="b", source="generated", world="grid", face_size=[8, 8], duration_s=420.5,)"
      R"( transition="fade", fade_s=2},)"
      R"({name="c", source="generated", world="demo", face_size=[12, 12], rate=25, duration_s=8,)"
      R"( transition="fade", fade_s=1.5, then="wait"},)"
      R"({name="d", source="generated", world="tree", face_size=[8, 8], duration_s=900, then="a"}])"};
  return load_show("demo", lines);
}

std::size_t open_files() {
  std::size_t count = 0;
  for ([[maybe_unused]] const auto& file : std::filesystem::directory_iterator("/proc/self/fd")) ++count;
  return count;
}

struct Kept {
  std::size_t heap = 0;  // bytes
  std::size_t files = 0;
};
Kept kept_now() {
  return {mallinfo2().uordblks, open_files()};
}

// An operator who is at it a few times an hour, and looks at what the player keeps.
class DayDisplay final : public Display {
 public:
  DayDisplay(Clock& clock, ControlLink& link) : display_(clock, 16, 12), link_(link) {
    std::vector<FakeDisplay::Absence> absences;
    for (int hour = 0; hour < kHours; hour += 6) absences.push_back({hour * 1h + 50min, hour * 1h + 51min});
    display_.set_absences(std::move(absences));
  }
  DisplayBuffer back_buffer() noexcept override { return display_.back_buffer(); }
  Presented present(nanoseconds when) noexcept override { return seen(display_.present(when)); }
  Presented repeat(nanoseconds when) noexcept override { return seen(display_.repeat(when)); }
  nanoseconds period() const noexcept override { return display_.period(); }
  const char* trouble() const noexcept override { return display_.trouble(); }

  Kept early, late;  // after half an hour, and at the last half hour
  std::int64_t flips() const { return flips_; }
  std::int64_t own_allocations() const { return own_allocations_; }  // for looking

 private:
  Presented seen(Presented presented) noexcept {
    constexpr std::int64_t kMinute = 60 * 60;
    const std::int64_t flip = flips_++;
    const std::int64_t before = heap_allocations().frame_loop;
    if (flip == 30 * kMinute) early = kept_now();
    if (flip == (60 * kHours - 5) * kMinute) late = kept_now();
    own_allocations_ += heap_allocations().frame_loop - before;
    if (flip % kMinute != 0) return presented;
    switch (flip / kMinute % 15) {
      case 3:
        link_.commands.push({PlayerAction::kFadeOut, 2s});
        break;
      case 4:
        link_.commands.push({PlayerAction::kFadeIn, 2s});
        break;
      case 7:
        link_.commands.push({PlayerAction::kSeek, 10s});
        break;
      case 9:
      case 10:
        link_.commands.push({PlayerAction::kPlayPause});
        break;
      case 13:
        link_.commands.push({PlayerAction::kGo});
        break;
      case 14:
        link_.commands.push({PlayerAction::kNext});
        break;
      default:
        break;
    }
    return presented;
  }
  FakeDisplay display_;
  ControlLink& link_;
  std::int64_t flips_ = 0;
  std::int64_t own_allocations_ = 0;
};

TEST(ShowDay, PassesWithoutALateFrameAndKeepsNothing) {
  FakeClock clock;
  WorkerPool pool(1);
  ShowFrames frames(small_show(), Method::kEwa, best_cpu(), pool);
  ControlLink link;
  DayDisplay display(clock, link);
  FrameLoop loop(frames, display, clock, pool, nullptr, &link);
  EXPECT_EQ(loop.run(kHours * 1h), LoopEnd::kTimeUp);
  const LoopCounts& counts = loop.counts();
  const double flips = kHours * 3600.0 * 60.0;
  EXPECT_NEAR(static_cast<double>(display.flips()), flips, 60.0 * kHours);
  EXPECT_EQ(counts.frames_presented + counts.frames_unshown, display.flips());
  EXPECT_EQ(counts.display_losses, (kHours + 5) / 6);
  EXPECT_NEAR(static_cast<double>(counts.frames_unshown), 3600.0 * static_cast<double>(counts.display_losses),
              2.0 * static_cast<double>(counts.display_losses));
  EXPECT_EQ(counts.frames_late, 0);
  EXPECT_EQ(counts.frames_dropped, 0);
  EXPECT_EQ(counts.frames_failed, 0);
  EXPECT_GT(counts.blackout_frames, 0);
  EXPECT_EQ(counts.heap_allocations, display.own_allocations());
  // The allocator's own lists differ by some hundred bytes in one run of several; a leak of 24 bytes at every
  // cue of the day would be more than this.
  EXPECT_LE(display.late.heap, display.early.heap + 4096) << "bytes of the heap";
  EXPECT_EQ(display.late.files, display.early.files);
  std::printf("a day of %d hours: %lld flips, %lld unchanged, %lld black\n", kHours,
              static_cast<long long>(display.flips()), static_cast<long long>(counts.frames_unchanged),
              static_cast<long long>(counts.blackout_frames));
}

}  // namespace
}  // namespace cupola
