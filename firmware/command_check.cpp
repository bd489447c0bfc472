// cupola check: every error that can be found in a show or a rig without playing it.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>

#include "firmware/command.h"
#include "firmware/rig_trial.h"
#include "firmware/show.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

class CheckCommand final : public Command {
 public:
  explicit CheckCommand(CLI::App& program)
      : Command(program, "check", "Check a show and every file it names, or a rig and every device in it",
                "  cupola check demo\n"
                "  cupola check --rig my-dome.toml\n") {
    options().add_option("show", show_, "The show's file, or the name of one in config/shows");
    options()
        .add_option("--rig", rig_, "A rig; together with a show, instead of the show's own")
        ->type_name("FILE");
  }

  int run() override;

 private:
  void check_show(std::vector<std::string>& errors) const;
  void check_rig(std::vector<std::string>& errors);

  std::string show_;
  std::string rig_;
  std::vector<std::string> troubles_;  // of the rig's devices
};

void describe(const Rig& rig) {
  std::string views;
  for (const View& view : rig.views) views += " " + view.name;
  fmt::print("{}: {} x {} pixels, views{}\n", rig.file.string(), rig.frame.size.width, rig.frame.size.height,
             views);
}

void CheckCommand::check_rig(std::vector<std::string>& errors) {
  try {
    const Rig rig = load_named_rig(rig_, overrides());
    const RigDevices devices = load_rig_devices(rig.file, overrides());
    describe(rig);
    troubles_ = try_rig(devices, rig.frame.size);
  } catch (const InputError& error) {
    errors.emplace_back(error.what());
  }
}

void CheckCommand::check_show(std::vector<std::string>& errors) const {
  WorkerPool pool(threads());
  const Show show = load_show(show_, overrides(), rig_, &errors);
  if (show.rig.views.empty()) return;  // nothing can be opened without the rig
  const bool readable = errors.empty();
  if (readable) describe(show.rig);
  for (const Cue& cue : show.cues) {
    if (cue.file.empty() && cue.world.empty()) continue;  // was reported
    try {
      const std::unique_ptr<FaceSource> source = open_source(cue, show.rig, pool);
      Rig rig = show.rig;
      fit_faces(rig, cue, *source);
      const std::optional<std::int64_t> length = source->length();
      if (readable) {
        const std::string lasts = cue.duration_s        ? fmt::format("{} s", *cue.duration_s)
                                  : length && !cue.loop ? grouped(*length) + " frames"
                                                        : "endless";
        fmt::print("cue {}: {}, {} a second\n", cue.name, lasts, cue.rate);
      }
    } catch (const InputError& error) {
      errors.emplace_back(fmt::format("cue {}: {}", cue.name, error.what()));
    }
  }
}

int CheckCommand::run() {
  cpu();
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
