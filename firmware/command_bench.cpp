// cupola bench: time beside error of the warp, and what a live show takes.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cmath>

#include <nlohmann/json.hpp>

#include "firmware/bench_live.h"
#include "firmware/bench_play.h"
#include "firmware/bench_prior.h"
#include "firmware/bench_stars.h"
#include "firmware/bench_warp.h"
#include "firmware/command.h"
#include "firmware/pareto.h"
#include "firmware/show.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

class BenchCommand final : public Command {
 public:
  explicit BenchCommand(CLI::App& program)
      : Command(program, "bench", "Measure time and error",
                "  cupola bench warp\n"
                "  cupola bench warp --rig domemaster-4k-5 --face-size 2048 --only speed\n"
                "  cupola bench warp --json figures.json\n"
                "  cupola bench warp --only quality --pareto out/pareto\n"
                "  cupola bench live --seconds 30\n"
                "  cupola bench play --set machine.priority=50\n"
                "  cupola bench prior PANORAMA.png ...\n") {
    options()
        .add_option("what", what_, "What to measure")
        ->required()
        ->check(CLI::IsMember({"warp", "live", "play", "prior"}));
    options()
        .add_option("photographs", photographs_, "prior: PNG, JPEG or TIFF files")
        ->check(CLI::ExistingFile);
    options().add_option("--rig", rig_, "The rig whose speed is measured")->type_name("FILE");
    options()
        .add_option("--face-size", face_size_, "Sides of its faces, texels")
        ->check(CLI::Range(8, 16384));
    options().add_option("--rounds", rounds_, "Rounds of timing")->check(CLI::Range(1, 1000));
    options()
        .add_option("--circle", circle_, "Diameter of the quality frames, pixels")
        ->check(CLI::Range(64, 4096));
    options()
        .add_option("--only", only_, "Leave the other parts out")
        ->check(CLI::IsMember({"speed", "quality", "stars"}));
    options()
        .add_option("--pareto", pareto_,
                    "Write quality's figures as NAME.csv and plot them: NAME.svg, NAME.png")
        ->type_name("NAME");
    options()
        .add_option("--seconds", seconds_, "live, play: how long each case is played, in real time")
        ->check(CLI::Range(1.0, 3600.0));
    options().add_option("--json", json_, "Write the figures too")->type_name("FILE");
  }

  int run() override;

 private:
  nlohmann::json report_speed(WorkerPool& pool) const;
  nlohmann::json report_quality(WorkerPool& pool) const;
  nlohmann::json report_stars(WorkerPool& pool) const;
  nlohmann::json report_live(WorkerPool& pool) const;
  nlohmann::json report_play(WorkerPool& pool) const;
  nlohmann::json report_prior() const;

  std::string what_;
  std::vector<std::filesystem::path> photographs_;
  std::string rig_ = "omnimax";
  int face_size_ = 1024;
  int rounds_ = 25;
  int circle_ = 983;
  double seconds_ = 10.0;
  std::string only_;
  std::string pareto_;
  std::string json_;
};

nlohmann::json BenchCommand::report_speed(WorkerPool& pool) const {
  Rig rig = load_named_rig(rig_, overrides());
  set_view_sizes(rig, std::vector<Size>(rig.views.size(), Size{face_size_, face_size_}));
  const Speed speed = measure_speed(rig, rounds_, true, pool);
  fmt::print("{}: {} x {} from {} faces of {} x {}, one core, medians of {} rounds\n", rig.file.string(),
             rig.frame.size.width, rig.frame.size.height, rig.views.size(), face_size_, face_size_, rounds_);
  const bool with_peer = speed.rows.size() > 1 && speed.rows[1].name.starts_with("OpenCV");
  fmt::print("{:<46} {:>8} {:>8} {:>9} {:>8} {:>8} {:>7} {:>6}\n", "", "ms", "ns/px", "x memcpy",
             with_peer ? "x peer" : "", "table B", "rms", "max");
  nlohmann::json rows = nlohmann::json::array();
  for (const SpeedRow& row : speed.rows) {
    const double copies = row.milliseconds / speed.rows[0].milliseconds;
    const double peers = with_peer ? row.milliseconds / speed.rows[1].milliseconds : 0.0;
    fmt::print("{:<46} {:>8.2f} {:>8.2f} {:>9.2f} {:>8} {:>8} {:>7} {:>6}\n", row.name, row.milliseconds,
               row.ns_per_pixel, copies, with_peer ? fmt::format("{:.3f}", peers) : "",
               row.bytes_per_pixel > 0 ? fmt::format("{:.1f}", row.bytes_per_pixel) : "",
               row.rms >= 0 ? fmt::format("{:.3f}", row.rms) : "",
               row.max >= 0 ? fmt::format("{:.2f}", row.max) : "");
    rows.push_back({{"name", row.name},
                    {"ms", row.milliseconds},
                    {"ns_per_pixel", row.ns_per_pixel},
                    {"times_memcpy", copies},
                    {"table_bytes_per_pixel", row.bytes_per_pixel}});
    if (with_peer) rows.back()["times_peer"] = peers;
    if (row.rms >= 0) {
      rows.back()["rms"] = row.rms;
      rows.back()["max"] = row.max;
    }
  }
  return rows;
}

// Root of the mean square of the scenes' errors, 8-bit steps.
double error_of(const QualityRow& row) {
  double squares = 0.0;
  for (const double psnr : row.psnr_db) squares += std::pow(10.0, -psnr / 10.0);
  return 255.0 * std::sqrt(squares / static_cast<double>(row.psnr_db.size()));
}

void write_pareto(const Quality& quality, const std::filesystem::path& name) {
  std::vector<ParetoPanel> panels;
  std::string csv = "minification,name,peer,ns_per_pixel,ms,rms_error,table_bytes,frontier";
  for (const std::string& scene : quality.scenes) csv += ",psnr_db " + scene;
  csv += '\n';
  for (const int minification : {1, 2, 4}) {
    std::vector<const QualityRow*> rows;
    std::vector<ParetoMark> marks;
    for (const QualityRow& row : quality.rows) {
      if (row.minification != minification) continue;
      rows.push_back(&row);
      marks.push_back({row.contender, row.ns_per_pixel, error_of(row), row.peer, false});
    }
    find_frontier(marks);
    for (std::size_t i = 0; i < rows.size(); ++i) {
      csv += fmt::format("{},{},{},{:.4g},{:.4g},{:.4g},{},{}", minification, marks[i].name,
                         marks[i].peer ? 1 : 0, marks[i].ns_per_pixel, rows[i]->milliseconds, marks[i].error,
                         rows[i]->table_bytes, marks[i].frontier ? 1 : 0);
      for (const double psnr : rows[i]->psnr_db) csv += fmt::format(",{:.3f}", psnr);
      csv += '\n';
    }
    panels.push_back({fmt::format("{} texels a pixel of the circle", minification), std::move(marks)});
  }
  AtomicFile file(std::filesystem::path(name).replace_extension("csv"));
  file.write(csv);
  file.commit();
  if (!draw_pareto(panels, name)) fmt::print("built without cairo: no plot\n");
}

nlohmann::json BenchCommand::report_quality(WorkerPool& pool) const {
  const Quality quality =
      measure_quality(usual_contenders(), {"rotated-checker", "zone-plate", "grid"}, circle_, pool);
  fmt::print("PSNR (dB) against the exact pixel integral, circle of {} pixels\n{:<24} {:>5}", circle_, "",
             "min.");
  for (const std::string& scene : quality.scenes) fmt::print(" {:>16}", scene);
  fmt::print(" {:>8}\n", "ms");
  nlohmann::json rows = nlohmann::json::array();
  for (const QualityRow& row : quality.rows) {
    fmt::print("{:<24} {:>3}:1", row.contender, row.minification);
    nlohmann::json scenes;
    for (std::size_t i = 0; i < row.psnr_db.size(); ++i) {
      fmt::print(" {:>16.2f}", row.psnr_db[i]);
      scenes[quality.scenes[i]] = row.psnr_db[i];
    }
    fmt::print(" {:>8.2f}\n", row.milliseconds);
    rows.push_back({{"name", row.contender},
                    {"minification", row.minification},
                    {"psnr_db", scenes},
                    {"ms", row.milliseconds}});
  }
  if (!pareto_.empty()) write_pareto(quality, pareto_);
  return rows;
}

nlohmann::json BenchCommand::report_stars(WorkerPool& pool) const {
  fmt::print("Energy of one-texel stars that drift in steps of 0.1 pixels, circle of {} pixels\n", circle_);
  fmt::print("{:<46} {:>7} {:>15} {:>12}\n", "", "ground", "mean variation", "worst swing");
  nlohmann::json rows = nlohmann::json::array();
  for (const StarRow& row : measure_stars(star_contenders(), circle_, pool)) {
    fmt::print("{:<46} {:>5} % {:>13.2f} % {:>10.1f} %\n", row.contender, row.ground,
               100 * row.mean_variation, 100 * row.worst_swing);
    rows.push_back({{"name", row.contender},
                    {"ground_percent", row.ground},
                    {"mean_variation", row.mean_variation},
                    {"worst_swing", row.worst_swing}});
  }
  return rows;
}

nlohmann::json BenchCommand::report_live(WorkerPool& pool) const {
  struct Case {
    int width, height;
    double rate;
  };
  const Rig rig = load_named_rig(rig_, overrides());
  fmt::print(
      "{}: {} x {} at 60 Hz from {} NV12 cameras, {} threads, {:g} s each, in real time\n"
      "times in ms: median, 99 %, 99.9 %, longest\n",
      rig.file.string(), rig.frame.size.width, rig.frame.size.height, rig.views.size(), pool.threads(),
      seconds_);
  nlohmann::json rows = nlohmann::json::array();
  for (const Case& each : {Case{1280, 720, 60.0}, Case{1920, 1080, 30.0}}) {
    PacedCameraDevice camera;
    camera.width = each.width;
    camera.height = each.height;
    camera.rate = each.rate;
    camera.jitter = std::chrono::milliseconds(1);
    camera.latency = std::chrono::milliseconds(4);
    const auto time = std::chrono::nanoseconds(std::llround(seconds_ * 1e9));
    const LiveBench bench = measure_live(rig, camera, time, cpu(), pool);
    const auto four = [](const Percentiles& times) {
      return fmt::format("{:.2f} {:.2f} {:.2f} {:.2f}", times.at(0.5), times.at(0.99), times.at(0.999),
                         times.at(1.0));
    };
    fmt::print(
        "{} x {} at {:g}: latency {}, warp {} ({:.0f} % of a period at 99 %), {} frames, {} late, {} "
        "dropped, "
        "{} of {} sets whole, {} bytes copied, {} allocations\n",
        each.width, each.height, each.rate, four(bench.latency_ms), four(bench.warp_ms),
        100.0 * bench.warp_ms.at(0.99) / bench.period_ms, bench.counts.frames_presented,
        bench.counts.frames_late, bench.counts.frames_dropped, bench.whole_sets, bench.sets,
        bench.bytes_copied, bench.counts.heap_allocations);
    const auto shares = [](const Percentiles& times) {
      return nlohmann::json{{"median", times.at(0.5)},
                            {"p99", times.at(0.99)},
                            {"p99_9", times.at(0.999)},
                            {"max", times.at(1.0)}};
    };
    rows.push_back({{"texels", {each.width, each.height}},
                    {"rate", each.rate},
                    {"latency_ms", shares(bench.latency_ms)},
                    {"warp_ms", shares(bench.warp_ms)},
                    {"frames_presented", bench.counts.frames_presented},
                    {"frames_late", bench.counts.frames_late},
                    {"frames_dropped", bench.counts.frames_dropped},
                    {"camera_frames_dropped", bench.frames_dropped},
                    {"sets", bench.sets},
                    {"whole_sets", bench.whole_sets},
                    {"pixel_bytes_copied", bench.bytes_copied},
                    {"heap_allocations", bench.counts.heap_allocations}});
  }
  return rows;
}

nlohmann::json BenchCommand::report_play(WorkerPool& pool) const {
  struct Case {
    const char* rig;
    int face;
    double rate;
    bool whole;
  };
  fmt::print(
      "the show demo in real time, {} threads, {:g} s each; work of a frame in per cent of the period: "
      "median, "
      "99 %, 99.9 %, longest\n",
      pool.threads(), seconds_);
  TableCache tables{cache_folder()};
  nlohmann::json rows = nlohmann::json::array();
  for (const Case& each :
       {Case{"omnimax", 1024, 60.0, false}, Case{"omnimax", 1024, 60.0, true},
        Case{"domemaster-4k-5", 2048, 30.0, false}, Case{"domemaster-4k-5", 2048, 30.0, true}}) {
    std::vector<std::string> lines = {fmt::format("cue.0.face_size=[{0}, {0}]", each.face),
                                      fmt::format("cue.0.rate={:.1f}", each.rate), "cue.0.loop=true",
                                      "cue.0.duration_s=1e6"};
    lines.insert(lines.end(), overrides().begin(), overrides().end());
    const Show show = load_show("demo", lines, each.rig);
    const auto time = std::chrono::nanoseconds(std::llround(seconds_ * 1e9));
    const PlayBench bench = measure_play(show, time, each.whole, cpu(), pool, &tables);
    const auto share = [&](double of) { return 100.0 * bench.work_ms.at(of) / bench.period_ms; };
    fmt::print(
        "{} x {} from {} faces of {} x {} at {:g} Hz, {}: {:.0f} {:.0f} {:.0f} {:.0f} %, {} frames, {} late, "
        "{} "
        "dropped, {} allocations\n",
        show.rig.frame.size.width, show.rig.frame.size.height, show.rig.views.size(), each.face, each.face,
        each.rate, each.whole ? "every pixel" : "what moves", share(0.5), share(0.99), share(0.999),
        share(1.0), bench.counts.frames_presented, bench.counts.frames_late, bench.counts.frames_dropped,
        bench.counts.heap_allocations);
    rows.push_back({{"rig", each.rig},
                    {"rate", each.rate},
                    {"every_pixel", each.whole},
                    {"period_ms", bench.period_ms},
                    {"work_ms",
                     {{"median", bench.work_ms.at(0.5)},
                      {"p99", bench.work_ms.at(0.99)},
                      {"p99_9", bench.work_ms.at(0.999)},
                      {"max", bench.work_ms.at(1.0)}}},
                    {"frames_presented", bench.counts.frames_presented},
                    {"frames_late", bench.counts.frames_late},
                    {"frames_dropped", bench.counts.frames_dropped},
                    {"heap_allocations", bench.counts.heap_allocations}});
  }
  return rows;
}

nlohmann::json BenchCommand::report_prior() const {
  if (photographs_.empty()) throw InputError("bench prior: expected photographs to fit to");
  const PriorFit fit = fit_prior(photographs_);
  fmt::print("{} photographs: exponent {:.2f}\n{:>8} {:>9} {:>7}\n", photographs_.size(), fit.exponent,
             "distance", "measured", "fitted");
  nlohmann::json rows = nlohmann::json::array();
  for (const Unlikeness& at : fit.distances) {
    fmt::print("{:>8} {:>9.2f} {:>7.2f}\n", at.distance, at.measured, at.fitted);
    rows.push_back({{"distance", at.distance}, {"measured", at.measured}, {"fitted", at.fitted}});
  }
  return {{"exponent", fit.exponent}, {"distances", rows}};
}

int BenchCommand::run() {
  WorkerPool pool(threads());
  nlohmann::json figures;
  const auto wanted = [&](std::string_view part) {
    return what_ == "warp" && (only_.empty() || only_ == part);
  };
  if (what_ == "live") figures["live"] = report_live(pool);
  if (what_ == "play") figures["play"] = report_play(pool);
  if (what_ == "prior") figures["prior"] = report_prior();
  if (wanted("speed")) figures["speed"] = report_speed(pool);
  if (wanted("quality")) figures["quality"] = report_quality(pool);
  if (wanted("stars")) figures["stars"] = report_stars(pool);
  if (!json_.empty()) {
    AtomicFile file(json_);
    file.write(figures.dump(2) + "\n");
    file.commit();
  }
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_bench_command(CLI::App& program) {
  return std::make_unique<BenchCommand>(program);
}

}  // namespace cupola
