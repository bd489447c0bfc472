// cupola check: every error that can be found in a show or a rig without playing it.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>
#include <filesystem>

#include "firmware/command.h"
#include "firmware/cue_trial.h"
#include "firmware/open_sound.h"
#include "firmware/parallax_report.h"
#include "firmware/rig_trial.h"
#include "firmware/show.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

class CheckCommand final : public Command {
 public:
  explicit CheckCommand(CLI::App& program)
      : Command(program, "check",
                "Check a show, every file it names and whether this machine holds its rate, or a rig and "
                "every device "
                "in it",
                "  cupola check demo\n"
                "  cupola check --rig my-dome.toml\n"
                "  cupola check --rig my-dome.toml --replay incident\n") {
    options().add_option("show", show_, "The show's file, or the name of one in config/shows");
    options()
        .add_option("--rig", rig_, "A rig; together with a show, instead of the show's own")
        ->type_name("FILE");
    options()
        .add_option("--replay", replay_,
                    "Beside --rig: try its cameras as they were in a folder that play --record wrote")
        ->type_name("DIR");
    offer_cache();
  }

  int run() override;

 private:
  void check_show(std::vector<std::string>& errors);
  void try_cues(const Show& show, WorkerPool& pool, std::vector<std::string>& errors);
  void check_rig(std::vector<std::string>& errors);

  std::string show_;
  std::string rig_;
  std::filesystem::path replay_;
  std::vector<std::string> troubles_;  // of the rig's devices; cues that are too slow
};

void describe(const Rig& rig) {
  std::string views;
  for (const View& view : rig.views) views += " " + view.name;
  fmt::print("{}: {} x {} pixels, views{}\n", rig.file.string(), rig.frame.size.width, rig.frame.size.height,
             views);
}

// How several sensors make one picture; nothing where it is left to them.
void print_colours(const RigDevices& devices) {
  std::string locked;
  for (const RigCamera& camera : devices.cameras) {
    if (!camera.colour) continue;
    locked += fmt::format(" {} ({:.3f} {:.3f} {:.3f})", camera.view, camera.colour->gain[0],
                          camera.colour->gain[1], camera.colour->gain[2]);
  }
  if (devices.live.match_colours) fmt::print("colours: matched, slowly\n");
  if (const auto& drive = devices.live.exposure) {
    fmt::print(
        "exposure: all alike, {:.0f} to {:.0f} microseconds, gain up to {:g}, to {:.0f} % brightness\n",
        drive->shortest_us, drive->longest_us, drive->most_gain, 100.0 * drive->brightness);
  }
  if (!locked.empty()) fmt::print("colours: locked:{}\n", locked);
}

// The cue's sound: opened, a line about it, or what is wrong with it.
void check_sound(const Cue& cue, const Rig& rig, bool readable, std::vector<std::string>& errors) {
  if (cue.sound.empty()) return;
  constexpr int kRate = 48000;
  try {
    const std::unique_ptr<SoundTrack> track = open_cue_sound(cue, rig, kRate, 0);
    if (!readable) return;
    fmt::print("cue {}: sound of {} channels, {:.1f} s\n", cue.name, track->file_channels(),
               static_cast<double>(track->length()) / kRate);
  } catch (const InputError& error) {
    errors.emplace_back(fmt::format("cue {}: {}", cue.name, error.what()));
  }
}

void check_live(const Cue& cue, const Show& show, bool readable, std::vector<std::string>& errors) {
  const std::size_t cameras = show.devices.cameras.size();
  const std::string rig = show.rig.file.string();
  if (cameras == 0) errors.push_back(fmt::format("cue {}: is live, but {} has no camera", cue.name, rig));
  if (readable && cameras > 0) {
    fmt::print("cue {}: live, {} camera{}; cupola check --rig {} tries them\n", cue.name, cameras,
               cameras == 1 ? "" : "s", rig);
  }
  check_sound(cue, show.rig, readable, errors);
}

void CheckCommand::check_rig(std::vector<std::string>& errors) {
  SettingsErrors wrong;
  try {
    const Rig rig = load_named_rig(rig_, overrides(), &wrong);
    const RigDevices devices = load_rig_devices(rig.file, overrides(), &wrong);
    if (wrong.lines().empty()) {
      describe(rig);
      print_parallax(rig, devices.cameras);
      print_colours(devices);
      troubles_ = replay_.empty() ? try_rig(rig, devices) : try_recording(rig, devices, replay_);
    }
  } catch (const InputError& error) {
    errors.emplace_back(error.what());
  }
  const std::vector<std::string> lines = wrong.lines();
  errors.insert(errors.begin(), lines.begin(), lines.end());
}

void CheckCommand::check_show(std::vector<std::string>& errors) {
  WorkerPool pool(threads());
  SettingsErrors wrong;
  Show show;
  try {
    show = load_show(show_, overrides(), rig_, &wrong);
  } catch (const InputError& error) {
    errors.emplace_back(error.what());
    return;
  }
  errors = wrong.lines();
  if (show.rig.views.empty()) return;  // nothing can be opened without the rig
  if (errors.empty()) describe(show.rig);
  try_cues(show, pool, errors);
}

void CheckCommand::try_cues(const Show& show, WorkerPool& pool, std::vector<std::string>& errors) {
  const bool readable = errors.empty();
  TableCache tables = cache();
  CueTrials trials(show.rig, cpu(), pool, &tables);
  for (const Cue& cue : show.cues) {
    if (cue.source == CueSource::kLive) {
      check_live(cue, show, readable, errors);
      continue;
    }
    if (cue.file.empty() && cue.world.empty()) continue;  // was reported
    try {
      const CueTrial trial = trials.run(cue);
      for (const std::string& fault : trial.faults)
        errors.push_back(fmt::format("cue {}: {}", cue.name, fault));
      if (!readable || !trial.faults.empty()) continue;
      const std::string line = fmt::format("cue {}: {}, {}", cue.name, trial.length, prediction(trial.cost));
      if (holds(trial.cost)) {
        fmt::print("{}\n", line);
      } else {
        troubles_.push_back(line);
      }
    } catch (const InputError& error) {
      errors.emplace_back(fmt::format("cue {}: {}", cue.name, error.what()));
    }
    check_sound(cue, show.rig, readable, errors);
  }
  if (readable && tables.found() + tables.built() > 0)
    fmt::print("warp tables: {} from the cache, {} built\n", tables.found(), tables.built());
  warn_about(tables);
}

int CheckCommand::run() {
  cpu();
  if (!replay_.empty() && (rig_.empty() || !show_.empty()))
    throw InputError("check: --replay is for --rig without a show");
  std::vector<std::string> errors;
  if (!show_.empty()) {
    check_show(errors);
  } else if (!rig_.empty()) {
    check_rig(errors);
  } else {
    throw InputError("check: expected a show or --rig FILE");
  }
  for (const std::string& error : errors) fmt::print(stderr, "{}\n", error);
  if (!errors.empty()) return 2;
  for (const std::string& trouble : troubles_) fmt::print(stderr, "{}\n", trouble);
  if (!troubles_.empty()) return 1;
  fmt::print("ok\n");
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_check_command(CLI::App& program) {
  return std::make_unique<CheckCommand>(program);
}

}  // namespace cupola
