// cupola warp: one set of faces to one frame, once or many times.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <nlohmann/json.hpp>

#include "firmware/command.h"
#include "firmware/face_options.h"
#include "firmware/held_budget.h"
#include "firmware/interrupt.h"
#include "firmware/show.h"
#include "firmware/skip_report.h"
#include "hal/time/clock.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/still.h"
#include "pipeline/optics/frame_map.h"
#include "pipeline/settings/settings.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {
namespace {

class WarpCommand final : public Command {
 public:
  explicit WarpCommand(CLI::App& program)
      : Command(program, "warp", "Warp one set of faces to one frame",
                "  cupola warp --rig omnimax --view front=f.png --view left=l.png --view right=r.png \\\n"
                "      --view top=t.png --out frame.png\n"
                "  cupola warp --rig my-dome.toml --atlas cube.png --layout 3x2 \\\n"
                "      --faces front,right,back,left,top,bottom --out frame.png --method ewa-exact\n"
                "  cupola warp --rig omnimax --world demo --out frame.png --repeat 100 --stats stats.json\n"),
        faces_(options()) {
    options()
        .add_option("--rig", rig_, "The rig's file, or the name of one in config/rigs")
        ->required()
        ->type_name("FILE");
    options().add_option("--out", out_, "The frame, a PNG or EXR")->required()->type_name("IMG");
    options()
        .add_option("--method", method_, fmt::format("{}", fmt::join(kMethodNames, ", ")))
        ->type_name("NAME");
    options()
        .add_option("--repeat", repeat_, "Do the whole warp N times")
        ->check(CLI::Range(1, 1'000'000'000))
        ->type_name("N");
    options()
        .add_option("--bits", bits_, "Of a sample in the frame, 8 or 16; those of the faces unless given")
        ->check(CLI::IsMember({8, 16}))
        ->type_name("N");
    options().add_option("--stats", stats_, "Write times and counts as JSON")->type_name("FILE");
    offer_cache();
  }

  int run() override;

 private:
  Method method() const {
    const auto* const found = std::find(std::begin(kMethodNames), std::end(kMethodNames), method_);
    if (found != std::end(kMethodNames)) return static_cast<Method>(found - std::begin(kMethodNames));
    const std::string_view nearest = nearest_name(method_, kMethodNames);
    throw InputError(fmt::format("--method {}: expected {}{}", method_, fmt::join(kMethodNames, ", "),
                                 nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
  }

  FaceOptions faces_;
  std::string rig_;
  std::string out_;
  std::string method_ = "ewa";
  std::int64_t repeat_ = 1;
  int bits_ = 0;
  std::string stats_;
};

int WarpCommand::run() {
  const Method by = method();
  const Cpu on = cpu();
  const StillFormat still = format_by_name(out_);
  if (still == StillFormat::kExr && bits_ == 8)
    throw InputError("--bits 8: expected a PNG as --out; EXR has half floats");
  WorkerPool pool(threads());
  Rig rig = load_named_rig(rig_, overrides());
  const Cue cue = faces_.cue(rig);
  const std::unique_ptr<FaceSource> source = open_source(cue, rig, pool);
  fit_faces(rig, cue, *source);

  MonotonicClock clock;
  TableCache tables = cache();
  if (by == Method::kEwa) {
    hold_budget(rig, source->format() == PixelFormat::kRgbPlanar16, on, pool, &tables);
  } else if (rig.budget_ms) {
    fmt::print(stderr, "cupola: {}: budget_ms is for the method ewa; {} has the default filter\n",
               rig.file.string(), method_);
  }
  if (rig.samples.linear_light && by != Method::kEwa && by != Method::kEwaExact) {
    fmt::print(stderr, "cupola: {}: light = linear is for ewa and ewa-exact; {} filters samples as encoded\n",
               rig.file.string(), method_);
  }
  const auto began = clock.now();
  const std::unique_ptr<FrameWarp> warp = make_frame_warp(rig, by, on, pool, &tables);
  const double build_s = std::chrono::duration<double>(clock.now() - began).count();
  warn_about(tables);

  source->prepare(warp->needed());
  FaceSet faces;
  const Fetch fetched = source->fetch(0, faces);
  if (fetched == Fetch::kFailed || fetched == Fetch::kEnd) {
    const auto* files = dynamic_cast<const FileFaces*>(source.get());
    throw InputError(files ? files->trouble() : "the faces could not be had");
  }

  const bool deep = still == StillFormat::kExr ||
                    (bits_ == 0 ? source->format() == PixelFormat::kRgbPlanar16 : bits_ == 16);
  ImageBuffer frame(deep ? PixelFormat::kRgb16 : PixelFormat::kRgb8, rig.frame.size);
  WarpWork work;
  std::vector<double> times_ms(static_cast<std::size_t>(repeat_));
  for (double& time_ms : times_ms) {
    if (interrupted()) throw Failure(fmt::format("{}: not written: interrupted", out_));
    const auto start = clock.now();
    work += warp->warp_known(faces.faces, {}, frame.pixels());
    time_ms = std::chrono::duration<double, std::milli>(clock.now() - start).count();
  }
  write_still(out_, as_const(frame.pixels()), still);

  const FrameMap map = map_frame(rig, pool);
  if (map.uncovered > 0) {
    fmt::print("{} pixels are covered by no view and stay black\n", grouped(map.uncovered));
  }
  if (stats_.empty()) return 0;
  std::sort(times_ms.begin(), times_ms.end());
  nlohmann::ordered_json needed;
  std::int64_t unneeded = 0;
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    const NeededRegion& region = warp->needed()[i];
    needed[rig.views[i].name] = region.texels();
    unneeded += std::int64_t{region.size.width} * region.size.height - region.texels();
  }
  nlohmann::ordered_json stats = {{"method", kMethodNames[static_cast<std::size_t>(by)]},
                                  {"cpu", name(on)},
                                  {"threads", pool.threads()},
                                  {"warps", repeat_},
                                  {"table_bytes", warp->table_bytes()},
                                  {"table_build_s", build_s},
                                  {"table_from_cache", tables.found() > 0},
                                  {"warp_ms_median", times_ms[times_ms.size() / 2]},
                                  {"warp_ms_min", times_ms.front()},
                                  {"warp_ms_max", times_ms.back()},
                                  {"pixels_in_image", map.in_image},
                                  {"pixels_uncovered", map.uncovered},
                                  {"needed_texels", needed}};
  report_skips(work, unneeded, 0, stats);
  AtomicFile file(stats_);
  file.write(stats.dump(2) + "\n");
  file.commit();
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_warp_command(CLI::App& program) {
  return std::make_unique<WarpCommand>(program);
}

}  // namespace cupola
