// cupola play: a show on a display, in real time.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>
#include <optional>
#include <tuple>

#include "firmware/command.h"
#include "firmware/control_panel.h"
#include "firmware/control_server.h"
#include "firmware/frame_loop.h"
#include "firmware/heap_count.h"
#include "firmware/live_frames.h"
#include "firmware/log_writer.h"
#include "firmware/open_cameras.h"
#include "firmware/open_display.h"
#include "firmware/open_sound.h"
#include "firmware/osc_server.h"
#include "firmware/play_report.h"
#include "firmware/player_watch.h"
#include "firmware/resume_show.h"
#include "firmware/show_frames.h"
#include "firmware/sound_text.h"
#include "hal/gpio/gpiod_lines.h"
#include "hal/time/clock.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/y4m_writer.h"

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
            "In a window, F fills the screen, Esc and q end the show; space pauses it, g goes on where it\n"
            "waits, n and the right arrow go to the next cue, p and the left arrow to the one before, b\n"
            "darkens it, f fades it out and in, + and - change the volume, t lays the next test pattern over "
            "it\n"
            "and takes the last one off, s writes a screenshot, r reads the show again.\n"
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
    options()
        .add_option("--trace", trace_,
                    "Write what the frame loop did in the last minute, for ui.perfetto.dev, when it ends")
        ->type_name("FILE");
    options()
        .add_option("--log", log_,
                    "text: what an operator should know; json: all that happens, an object a line, for "
                    "programs that collect logs")
        ->check(CLI::IsMember({"text", "json"}))
        ->type_name("FORM");
    options().add_flag("--fast-forward", fast_forward_,
                       "Do not wait for the time of a frame (fake display only)");
    options()
        .add_option("--http", http_,
                    "Let a browser control the show; without a token 127.0.0.1:8080 or the like")
        ->type_name("ADDRESS:PORT");
    options()
        .add_option("--osc", osc_, "Take OSC messages over UDP; without a token 127.0.0.1:9000 or the like")
        ->type_name("ADDRESS:PORT");
    options()
        .add_option("--token-file", token_file_, "The file whose first line others must know")
        ->type_name("FILE");
    options()
        .add_option("--record", recordings_.record,
                    "Write what live cameras send into a folder, a file VIEW.camera each")
        ->type_name("DIR");
    options()
        .add_option("--replay", recordings_.replay, "Play a folder that --record wrote, as if it were live")
        ->type_name("DIR");
    options()
        .add_option("--resume", resume_,
                    "Keep the show's position in this file; where it is there already, go on where the show "
                    "would be by now")
        ->type_name("FILE");
    offer_cache();
  }

  int run() override;

 private:
  void check_options() const;
  void check(const Show& show) const;
  ControlSettings control(const Show& show) const;
  // None: until the show is over, which a display without time of its own refuses of one that never is.
  std::optional<std::chrono::nanoseconds> time_to_play(const ShowFrames& frames) const;
  bool in_real_time() const { return !fast_forward_ && display_ != "file"; }

  std::string show_;
  std::string rig_;
  std::string display_ = "auto";
  std::string out_;
  double seconds_ = 0.0;
  std::string stats_;
  std::string trace_;
  std::string log_ = "text";
  std::string resume_;
  std::string http_;
  std::string osc_;
  std::string token_file_;
  CameraRecordings recordings_;
  bool fast_forward_ = false;
};

// The show's, and what the command line says instead.
ControlSettings PlayCommand::control(const Show& show) const {
  ControlSettings control = show.control;
  if (!token_file_.empty()) control.token_file = token_file_;
  for (const auto& [option, text, listened] :
       {std::tuple("--http", &http_, &control.http), std::tuple("--osc", &osc_, &control.osc)}) {
    if (text->empty()) continue;
    try {
      *listened = parse_control_address(*text);
    } catch (const InputError& error) {
      throw InputError(fmt::format("{} {}", option, error.what()));
    }
    if (!(*listened)->loopback && control.token_file.empty()) {
      throw InputError(fmt::format("{} {}: expected --token-file FILE with an address that others can reach",
                                   option, *text));
    }
  }
  return control;
}

void PlayCommand::check_options() const {
  if ((display_ == "file") != !out_.empty())
    throw InputError("play: --display file and --out belong together");
  expect_pipe(out_);
  if (fast_forward_ && display_ != "fake") throw InputError("play: --fast-forward is for --display fake");
  if (!resume_.empty() && !in_real_time()) throw InputError("play: --resume is for a show in real time");
}

std::optional<std::chrono::nanoseconds> PlayCommand::time_to_play(const ShowFrames& frames) const {
  if (seconds_ > 0.0) return std::chrono::nanoseconds(std::llround(seconds_ * 1e9));
  if (!in_real_time() && !frames.timeline().length()) {
    throw InputError(fmt::format("{}: the show never ends; expected --seconds N", show_));
  }
  return std::nullopt;
}

// What a show and a command line ask for must go together before anything opens.
void PlayCommand::check(const Show& show) const {
  if (!show.live() && !(recordings_.record.empty() && recordings_.replay.empty())) {
    throw InputError("play: --record and --replay are for shows with live cues");
  }
  if (show.live() && show.rig.budget_ms) {
    throw InputError(fmt::format("{}: filter.budget_ms: expected a preset or a kernel where a cue is live",
                                 show.rig.file.string()));
  }
}

int PlayCommand::run() {
  check_options();
  const Cpu on = cpu();
  WorkerPool pool(threads());
  const Show what = load_show(show_, overrides(), rig_);
  check(what);
  const ControlSettings who = control(what);
  const std::string token = who.token_file.empty() ? "" : read_token(who.token_file);

  MonotonicClock real;
  FakeClock fake;
  Clock& clock = in_real_time() ? static_cast<Clock&>(real) : fake;
  CameraDrivers drivers;
  std::unique_ptr<LiveFrames> live;
  TableCache tables = cache();
  if (what.live()) {
    auto cameras = drivers.open(what.devices.cameras, clock, in_real_time() ? nullptr : &fake, recordings_);
    live = std::make_unique<LiveFrames>(what.rig, std::move(cameras), what.devices.live, on, pool, clock,
                                        &tables);
  }
  auto opened = std::make_unique<ShowFrames>(what, Method::kEwa, on, pool, false, &tables,
                                             in_real_time() ? Decoding::kAhead : Decoding::kAheadInStep,
                                             std::move(live));
  ShowFrames& frames = *opened;
  warn_about(tables);
  const std::optional<std::chrono::nanoseconds> time = time_to_play(frames);

  ControlLink link;
  const LogWriter log(link.log, log_ == "json" ? LogForm::kJson : LogForm::kText, stderr);
  std::optional<Y4mWriter> video;
  std::unique_ptr<Display> display;
  try {
    display = open_display(display_, out_, clock, what, frames.rate(), video, link.commands);
  } catch (const std::runtime_error& error) {
    throw Failure(error.what());
  }
  // Buttons and lamps live in real time.
  const std::unique_ptr<Gpio> gpio = make_gpiod_lines(real);
  std::optional<ControlPanel> panel;
  if (in_real_time() && !what.devices.gpio.empty()) panel.emplace(what.devices.gpio, *gpio, real, link.log);
  const ShowFacts facts = facts_of(what, display_);
  std::optional<PatternBoard> patterns;
  std::optional<Screenshots> screenshots;
  std::optional<ShowReload> reload;
  if (in_real_time()) {
    link.patterns = &patterns.emplace(what.rig.frame.size, pattern_drawer(what, on, cache()), link.log);
    link.screenshots = &screenshots.emplace(
        what.rig.frame.size, screenshot_writer(what.file.parent_path() / "screenshots", what.name), link.log);
  }
  std::optional<OpenSound> device;
  if (in_real_time() && what.sounds()) {
    device = open_sound_device(what, frames.timeline(), clock, link.log);
  }
  if (in_real_time()) {
    auto first = std::make_unique<ReadyShow>();
    first->maker = std::move(opened);
    first->facts = facts;
    link.reload = &reload.emplace(
        std::move(first),
        reopen_show(what, show_, overrides(), rig_, display_, on, cache(),
                    device ? std::optional(device->mode) : std::nullopt, &*patterns),
        [&](WorkerPool& fresh) {
          for (const std::string& line : settle(what.machine, fresh)) link.log.warn(Topic::kMachine, line);
          join_frame_loop(fresh);
        },
        pool.threads(), what.rig.frame.size, link.status, link.log);
  }
  std::optional<Preview> preview;
  std::optional<FacePreviews> faces;
  std::unique_ptr<ControlServer> server;
  if (who.http) {
    link.preview = &preview.emplace(what.rig.frame.size);
    link.faces = &faces.emplace();
    server = start_control_server(*who.http, token, facts, link, real);
    link.log.notice(Topic::kControl, fmt::format("control at http://{}/", describe(server->address())));
  }
  std::unique_ptr<OscServer> osc;
  if (who.osc) {
    osc = start_osc_server(*who.osc, token, facts, link, real);
    link.log.notice(Topic::kControl, fmt::format("OSC at udp://{}/", describe(osc->address())));
  }
  link.commands.push({.action = PlayerAction::kVolume, .volume = what.sound.volume});
  std::optional<SoundThread> sound;
  if (device) sound.emplace(what.sound, std::move(*device), clock, link);
  ServiceNotice notice;
  std::optional<PlayerWatch> watch;
  if (in_real_time() && (notice.wanted() || !resume_.empty())) watch.emplace(link, notice, facts, resume_);
  if (in_real_time()) {  // now that all others have their threads
    for (const std::string& line : settle(what.machine, pool)) link.log.warn(Topic::kMachine, line);
  }

  FrameLoop loop(frames, *display, clock, pool, panel ? &*panel : nullptr, &link);
  if (!resume_.empty()) resume_show(resume_, frames, facts, link);  // as late as can be: time passes
  const LoopEnd end = loop.run(time);
  watch.reset();
  sound.reset();
  server.reset();
  osc.reset();
  const auto& last = reload ? dynamic_cast<const ShowFrames&>(reload->end()) : frames;
  if (!resume_.empty() && (end == LoopEnd::kOver || end == LoopEnd::kClosed)) {
    std::error_code ignored;
    std::filesystem::remove(resume_, ignored);  // it ended as it should
  }
  if (!stats_.empty()) {
    nlohmann::ordered_json stats = play_stats(loop, panel ? panel->counts() : GpioCounts(), last);
    if (what.sounds()) stats["sound"] = describe(link.sound.read());
    stats.update(
        {{"show", what.name}, {"display", display_}, {"cpu", name(on)}, {"threads", pool.threads()}});
    AtomicFile file(stats_);
    file.write(stats.dump(2) + "\n");
    file.commit();
  }
  if (!trace_.empty()) {
    AtomicFile file(trace_);
    file.write(link.trace.json());
    file.commit();
  }
  if (last.live()) report_recordings(*last.live());
  if (end == LoopEnd::kLost) throw Failure(display->trouble());
  if (video) video->finish();
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_play_command(CLI::App& program) {
  return std::make_unique<PlayCommand>(program);
}

}  // namespace cupola
