// cupola play: a show on a display, in real time.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <optional>

#include "firmware/command.h"
#include "firmware/control_panel.h"
#include "firmware/file_display.h"
#include "firmware/frame_loop.h"
#include "firmware/live_frames.h"
#include "firmware/open_cameras.h"
#include "firmware/show_frames.h"
#include "hal/display/fake_display.h"
#include "hal/gpio/gpiod_lines.h"
#include "hal/time/clock.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/numbered_frames.h"
#include "pipeline/frame/y4m_writer.h"
#ifdef CUPOLA_KMS
#include "hal/display/kms_display.h"
#endif
#ifdef CUPOLA_WINDOW
#include "hal/display/window_display.h"
#endif

namespace cupola {
namespace {

class PlayCommand final : public Command {
 public:
  explicit PlayCommand(CLI::App& program)
      : Command(
            program, "play", "Play a show",
            "  cupola play demo\n"
            "  cupola play my-show.toml --display window --set rig.tilt_deg=20\n"
            "  cupola play demo --display fake --seconds 60 --stats stats.json\n"
            "  cupola play demo --display file --out frames --seconds 2\n"
            "\n"
            "In a window, F fills the screen, Esc and q end the show.\n"
            "In the stats, heap_allocations counts calls of operator new by the frame loop's thread and the\n"
            "warp's threads after the first frame was asked for; C libraries' own malloc is not in it.\n") {
    options().add_option("show", show_, "The show's file, or the name of one in config/shows")->required();
    options()
        .add_option("--display", display_,
                    "auto, kms (a projector without a desktop), window, file (PNGs or Y4M, not in real time) "
                    "or fake (60 Hz)")
        ->check(CLI::IsMember({"auto", "kms", "window", "file", "fake"}))
        ->type_name("NAME");
    options().add_option("--rig", rig_, "Another rig than the show's")->type_name("FILE");
    options()
        .add_option("--out", out_, "For --display file: a folder, FILE.y4m, or - for Y4M to standard output")
        ->type_name("DIR|FILE|-");
    options()
        .add_option("--seconds", seconds_, "Play so much of the show")
        ->check(CLI::Range(0.0, 1e9))
        ->type_name("N");
    options().add_option("--stats", stats_, "Write what was counted as JSON")->type_name("FILE");
    options().add_flag("--fast-forward", fast_forward_,
                       "Do not wait for the time of a frame (fake display only)");
    offer_cache();
  }

  int run() override;

 private:
  // `video` is made where the frames are to go into one; it outlives the display.
  std::unique_ptr<Display> open_display(Clock& clock, const Show& show, double rate,
                                        std::optional<Y4mWriter>& video) const;
  void write_stats(const FrameLoop& loop, const GpioCounts& gpio, const LiveFrames* live, const Show& show,
                   Cpu on, int pool_threads) const;

  std::string show_;
  std::string rig_;
  std::string display_ = "auto";
  std::string out_;
  double seconds_ = 0.0;
  std::string stats_;
  bool fast_forward_ = false;
};

bool has_desktop() {
  for (const char* name : {"DISPLAY", "WAYLAND_DISPLAY"}) {
    const char* value = std::getenv(name);
    if (value && *value) return true;
  }
  return false;
}

bool has_projector() {
#ifdef CUPOLA_KMS
  for (const KmsCard& card : list_kms_cards()) {
    if (choose_kms_connector(card.connectors, "")) return true;
  }
#endif
  return false;
}

std::unique_ptr<Display> PlayCommand::open_display(Clock& clock, const Show& show, double rate,
                                                   std::optional<Y4mWriter>& video) const {
  const Size size = show.rig.frame.size;
  if (display_ == "fake") return std::make_unique<FakeDisplay>(clock, size.width, size.height);
  if (display_ == "file" && is_video_name(out_)) {
    video.emplace(out_, size, frame_rate(rate));
    return std::make_unique<FileDisplay>(clock, size, [&video](const Image& frame) { video->write(frame); });
  }
  if (display_ == "file") {
    return std::make_unique<FileDisplay>(clock, size,
                                         [files = NumberedFrames(out_, show.name), count = std::int64_t{0}](
                                             const Image& frame) mutable { files.write(count++, frame); });
  }
  if (display_ == "kms" || (display_ == "auto" && !has_desktop() && has_projector())) {
#ifdef CUPOLA_KMS
    const ProjectorSettings& projector = show.devices.projector;
    const KmsSettings settings{projector.connector, projector.mode, projector.card, KmsMemoryKind::kDumb};
    return std::make_unique<KmsDisplay>(clock, settings, size.width, size.height);
#else
    throw Failure("play: this program was built without KMS");
#endif
  }
  if (display_ == "auto" && !has_desktop()) {
    throw Failure(
        "play: there is no desktop and no projector; expected --display file with --out DIR, or --display "
        "fake");
  }
#ifdef CUPOLA_WINDOW
  return std::make_unique<WindowDisplay>(clock, "Cupola: " + show.name, size.width, size.height);
#else
  throw Failure("play: this program was built without windows");
#endif
}

nlohmann::ordered_json live_stats(const LiveFrames& live) {
  std::vector<double> latencies = live.latencies_ms();
  std::sort(latencies.begin(), latencies.end());
  const auto share = [&](double part) {
    return latencies.empty()
               ? 0.0
               : latencies[static_cast<std::size_t>(part * static_cast<double>(latencies.size() - 1))];
  };
  const RigSync& sync = live.faces().sync();
  nlohmann::ordered_json stats = {{"sets", sync.counts().sets},
                                  {"whole_sets", sync.counts().whole},
                                  {"frames_passed_over", sync.counts().passed_over},
                                  {"latency_ms_median", share(0.5)},
                                  {"latency_ms_p99", share(0.99)},
                                  {"latency_ms_max", share(1.0)},
                                  {"cameras", nlohmann::ordered_json::array()}};
  for (std::size_t c = 0; c < live.cameras().size(); ++c) {
    const CameraCounts& counts = live.watch(c).counts();
    stats["cameras"].push_back({{"view", live.cameras()[c].settings.view},
                                {"frames", counts.frames},
                                {"dropped", counts.dropped},
                                {"damaged", counts.damaged},
                                {"losses", counts.losses},
                                {"silences", counts.silences},
                                {"clock_steps", counts.clock_steps}});
  }
  return stats;
}

void PlayCommand::write_stats(const FrameLoop& loop, const GpioCounts& gpio, const LiveFrames* live,
                              const Show& show, Cpu on, int pool_threads) const {
  const LoopCounts& counts = loop.counts();
  std::vector<double> times = loop.warp_ms();
  std::sort(times.begin(), times.end());
  const auto share = [&](double part) {
    return times.empty() ? 0.0
                         : times[static_cast<std::size_t>(part * static_cast<double>(times.size() - 1))];
  };
  nlohmann::ordered_json stats = {
      {"frames_presented", counts.frames_presented},
      {"frames_late", counts.frames_late},
      {"frames_dropped", counts.frames_dropped},
      {"frames_unshown", counts.frames_unshown},
      {"display_losses", counts.display_losses},
      {"frames_unchanged", counts.frames_unchanged},
      {"tiles_warped", counts.tiles_warped},
      {"tiles_skipped", counts.tiles_skipped},
      {"frames_failed", counts.frames_failed},
      {"blackout_frames", counts.blackout_frames},
      {"gpio_edges", gpio.edges},
      {"gpio_losses", gpio.losses},
      {"gpio_returns", gpio.returns},
      {"heap_allocations", counts.heap_allocations},
      {"heap_allocations_elsewhere", counts.heap_allocations_elsewhere},
      {"pixel_bytes_copied", counts.pixel_bytes_copied + (live ? live->pixel_bytes_copied() : 0)},
      {"warp_ms_median", share(0.5)},
      {"warp_ms_p99_9", share(0.999)},
      {"warp_ms_max", share(1.0)},
      {"show", show.name},
      {"display", display_},
      {"cpu", name(on)},
      {"threads", pool_threads}};
  if (live) stats["live"] = live_stats(*live);
  AtomicFile file(stats_);
  file.write(stats.dump(2) + "\n");
  file.commit();
}

int PlayCommand::run() {
  const Cpu on = cpu();
  if ((display_ == "file") != !out_.empty())
    throw InputError("play: --display file and --out belong together");
  expect_pipe(out_);
  if (fast_forward_ && display_ != "fake") throw InputError("play: --fast-forward is for --display fake");
  WorkerPool pool(threads());
  const Show what = load_show(show_, overrides(), rig_);
  MonotonicClock real;
  FakeClock fake;
  Clock& clock = fast_forward_ || display_ == "file" ? static_cast<Clock&>(fake) : static_cast<Clock&>(real);
  CameraDrivers drivers;
  std::unique_ptr<LiveFrames> live;
  std::unique_ptr<ShowFrames> frames;
  if (what.live()) {
    live = std::make_unique<LiveFrames>(
        what.rig, drivers.open(what.devices.cameras, clock, &clock == &fake ? &fake : nullptr),
        what.devices.sync, on, pool, clock);
  } else {
    TableCache tables = cache();
    frames = std::make_unique<ShowFrames>(what, Method::kEwa, on, pool, false, &tables);
    warn_about(tables);
  }
  FrameMaker& maker = live ? static_cast<FrameMaker&>(*live) : *frames;
  std::optional<std::chrono::nanoseconds> time;
  if (seconds_ > 0.0) time = std::chrono::nanoseconds(std::llround(seconds_ * 1e9));
  if (live && !time && what.cues.front().duration_s) {
    time = std::chrono::nanoseconds(std::llround(*what.cues.front().duration_s * 1e9));
  }
  const bool ends = time || (frames && frames->timeline().length());
  if ((fast_forward_ || display_ == "file") && !ends) {
    throw InputError(fmt::format("{}: the show never ends; expected --seconds N", show_));
  }
  std::optional<Y4mWriter> video;
  std::unique_ptr<Display> display;
  try {
    display = open_display(clock, what, maker.rate(), video);
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
  // Buttons and lamps live in real time.
  const std::unique_ptr<Gpio> gpio = make_gpiod_lines(real);
  std::optional<ControlPanel> panel;
  if (&clock == &real && !what.devices.gpio.empty()) panel.emplace(what.devices.gpio, *gpio, real);
  FrameLoop loop(maker, *display, clock, pool, panel ? &*panel : nullptr);
  const LoopEnd end = loop.run(time);
  if (!stats_.empty()) {
    write_stats(loop, panel ? panel->counts() : GpioCounts(), live.get(), what, on, pool.threads());
  }
  if (end == LoopEnd::kLost) throw Failure(display->trouble());
  if (video) video->finish();
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_play_command(CLI::App& program) {
  return std::make_unique<PlayCommand>(program);
}

}  // namespace cupola
