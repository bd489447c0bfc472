// Quality against ground truth and speed against memcpy and a peer.
// SPDX-License-Identifier: MIT
#include "firmware/bench_warp.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
#include <memory>

#include "firmware/bench_native.h"
#include "firmware/bench_skipping.h"
#include "firmware/frame_error.h"
#include "firmware/peer.h"
#include "hal/time/cpu_time.h"
#include "pipeline/optics/frame_map.h"
#include "pipeline/source/generated_source.h"
#include "pipeline/source/ground_truth.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"

namespace cupola {
namespace {

double milliseconds(std::chrono::nanoseconds time) {
  return static_cast<double>(time.count()) / 1e6;
}

double median(std::vector<double> values) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2),
                   values.end());
  return values[values.size() / 2];
}

double cpu_milliseconds(const std::function<void()>& work) {
  const auto begin = thread_cpu_time();
  work();
  return milliseconds(thread_cpu_time() - begin);
}

// A generated world's faces, kept in memory.
struct WorldFaces {
  std::unique_ptr<GeneratedSource> source;
  FaceSet set;
};

WorldFaces draw_faces(const Rig& rig, const std::string& world, WorkerPool& pool) {
  WorldFaces faces;
  faces.source =
      std::make_unique<GeneratedSource>(rig.views, rig.world_from_lens, make_world(world), 60.0, pool);
  std::vector<NeededRegion> all;
  for (const View& view : rig.views) all.push_back(NeededRegion::all(view.size));
  faces.source->prepare(all);
  faces.source->fetch(0, faces.set);
  return faces;
}

// Over pixels of the image, planes of doubles as render_truth_exact gives them.
double psnr(const Rig& rig, const Image& frame, const std::vector<double>& truth) {
  const auto width = static_cast<std::size_t>(frame.size.width);
  const auto height = static_cast<std::size_t>(frame.size.height);
  double squares = 0.0;
  std::int64_t count = 0;
  for (std::size_t y = 0; y < height; ++y) {
    for (std::size_t x = 0; x < width; ++x) {
      DirectionAndSlope ignored;
      if (!ray(rig.frame, {static_cast<double>(x) + 0.5, static_cast<double>(y) + 0.5}, ignored)) continue;
      for (std::size_t channel = 0; channel < 3; ++channel) {
        const double error = frame.samples<std::uint8_t>(static_cast<int>(channel), static_cast<int>(y))[x] -
                             truth[(channel * height + y) * width + x];
        squares += error * error;
        ++count;
      }
    }
  }
  return 10.0 * std::log10(255.0 * 255.0 * static_cast<double>(count) / squares);
}

}  // namespace

Rig paper_shape(int circle, int face) {
  Rig rig;
  rig.frame.size = {circle, (circle * 1436 + 983) / 1966};
  rig.frame.center = {circle / 2.0, circle / 2.0};
  rig.frame.radius = circle / 2.0;
  rig.frame.lens = omnimax_c430();
  for (const char* name : {"front", "left", "right", "top"}) {
    View view;
    view.name = name;
    named_pose(name, view);
    view.size = {face, face};
    rig.views.push_back(view);
  }
  return rig;
}

std::vector<Contender> usual_contenders() {
  const auto gaussian = [](double alpha, double radius, double rec) {
    return FilterSettings{Kernel::kGaussian, alpha, radius, rec, TableForm::kFast};
  };
  const auto precise = [](FilterSettings filter) {
    filter.table = TableForm::kPrecise;
    return filter;
  };
  return {{"ewa", Method::kEwa, {}},
          {"ewa paper", Method::kEwa, paper_preset()},
          {"ewa a2 r1", Method::kEwa, gaussian(2, 1, 0)},
          {"ewa a2 r1 rec 1", Method::kEwa, gaussian(2, 1, 1)},
          {"ewa a4 r1.25", Method::kEwa, gaussian(4, 1.25, 0)},
          {"ewa a4 r1 rec 0.25", Method::kEwa, gaussian(4, 1, 0.25)},
          {"ewa a6 r1 rec 0.25", Method::kEwa, gaussian(6, 1, 0.25)},
          {"ewa a6 r1 rec 0.75", Method::kEwa, gaussian(6, 1, 0.75)},
          {"ewa a6 r1 rec 1", Method::kEwa, gaussian(6, 1, 1)},
          {"ewa a8 r1 rec 1", Method::kEwa, gaussian(8, 1, 1)},
          {"ewa precise", Method::kEwa, precise(default_gaussian())},
          {"ewa paper precise", Method::kEwa, precise(paper_preset())},
          {"optimal precise", Method::kEwa, precise(optimal_filter())},
          {"ewa robidoux", Method::kEwa, robidoux_filter()},
          {"ewa jinc", Method::kEwa, jinc_filter()},
          {"optimal 0.0001", Method::kEwa, optimal_filter(0.0001)},
          {"optimal 0.001", Method::kEwa, optimal_filter(0.001)},
          {"optimal 0.003", Method::kEwa, optimal_filter(0.003)},
          {"optimal 0.01", Method::kEwa, optimal_filter(0.01)},
          {"ewa-scan", Method::kEwaScan, {}},
          {"ewa-scan-integer", Method::kEwaScanInteger, {}},
          {"ewa-pyramid", Method::kEwaPyramid, {}},
          {"two-pass", Method::kTwoPass, {}},
          {"trilinear", Method::kTrilinear, {}},
          {"summed-area", Method::kSummedArea, {}},
          {"bilinear", Method::kBilinear, {}},
          {"nearest", Method::kNearest, {}}};
}

Quality measure_quality(const std::vector<Contender>& contenders, const std::vector<std::string>& scenes,
                        int circle, WorkerPool& pool) {
  Quality quality{scenes, {}};
  WorkerPool alone(1);
  const Rig shape = paper_shape(circle, 1);
  std::vector<std::vector<double>> truths;
  for (const std::string& scene : scenes) {
    truths.push_back(
        render_truth_exact(shape.frame, shape.world_from_lens, *make_world(scene), 0.0, 16, pool));
  }
  for (const int minification : {1, 2, 4}) {
    Rig rig = paper_shape(circle, circle * 512 * minification / 983);
    std::vector<WorldFaces> faces;
    for (const std::string& scene : scenes) faces.push_back(draw_faces(rig, scene, pool));
    const double pixels = static_cast<double>(map_frame(rig, pool).in_image);
    for (const Contender& contender : contenders) {
      rig.filter = contender.filter;
      const auto warp = make_frame_warp(rig, contender.method, best_cpu(), alone);
      QualityRow row{contender.name, minification, {}, 0.0, 0.0, warp->table_bytes(), false};
      ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
      std::vector<double> times;
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        for (int repeat = 0; repeat < 3; ++repeat) {
          times.push_back(cpu_milliseconds([&] { warp->warp(faces[i].set.faces, frame.pixels()); }));
        }
        row.psnr_db.push_back(psnr(rig, as_const(frame.pixels()), truths[i]));
      }
      row.milliseconds = median(times);
      row.ns_per_pixel = row.milliseconds * 1e6 / pixels;
      quality.rows.push_back(std::move(row));
    }
    for (const PeerFilter filter : {PeerFilter::kBilinear, PeerFilter::kLanczos4}) {
      QualityRow row{"", minification, {}, 0.0, 0.0, 0, true};
      std::vector<double> times;
      ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
      for (std::size_t i = 0; i < scenes.size(); ++i) {
        const std::unique_ptr<Peer> peer = make_peer(rig, faces[i].set.faces, filter, pool);
        if (!peer) break;
        row.contender = peer->name();
        for (int repeat = 0; repeat < 3; ++repeat) times.push_back(cpu_milliseconds([&] { peer->warp(); }));
        convert(peer->frame(), frame.pixels());
        row.psnr_db.push_back(psnr(rig, as_const(frame.pixels()), truths[i]));
      }
      if (times.empty()) continue;
      row.milliseconds = median(times);
      row.ns_per_pixel = row.milliseconds * 1e6 / pixels;
      quality.rows.push_back(std::move(row));
    }
  }
  return quality;
}

Speed measure_speed(const Rig& rig, int rounds, bool with_error, WorkerPool& pool) {
  WorkerPool alone(1);
  const FrameMap map = map_frame(rig, pool);
  const std::vector<ImageBuffer> buffers = noise_faces(rig);
  std::vector<Image> faces;
  for (const ImageBuffer& buffer : buffers) faces.push_back(buffer.pixels());
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  ImageBuffer copy(PixelFormat::kRgbPlanar8, rig.frame.size);
  std::vector<Lap> laps;
  laps.push_back(
      {{"memcpy of the frame", 0, 0, 0, -1, -1},
       [&] { std::memcpy(copy.pixels().planes[0].data, frame.pixels().planes[0].data, frame.bytes()); },
       {}});
  const std::unique_ptr<Peer> peer = make_peer(rig, faces, PeerFilter::kBilinear, pool);
  if (peer) laps.push_back({{peer->name(), 0, 0, 0, -1, -1}, [&] { peer->warp(); }, {}});

  std::vector<std::unique_ptr<WarpTable>> tables;
  std::vector<std::unique_ptr<FrameWarp>> warps;
  std::vector<double> exact;
  const double in_image = static_cast<double>(map.in_image);
  const auto add_table = [&](const std::string& name, const FilterSettings& filter,
                             const std::vector<Cpu>& cpus) {
    Rig own = rig;
    own.filter = filter;
    tables.push_back(std::make_unique<WarpTable>(build_warp_table(own, pool)));
    SpeedRow row{name, 0, 0, static_cast<double>(tables.back()->bytes()) / in_image, -1, -1};
    if (with_error) {
      exact = ewa_exact_frame(own, faces, pool);
      make_table_warp(*tables.back(), best_cpu(), pool)->warp(faces, frame.pixels());
      const FrameError error = frame_error(map, as_const(frame.pixels()), exact);
      row.rms = error.rms;
      row.max = error.max;
    }
    for (const Cpu cpu : cpus) {
      if (!supported(cpu)) continue;
      warps.push_back(make_table_warp(*tables.back(), cpu, alone));
      row.name = name + ", " + std::string(cupola::name(cpu));
      laps.push_back({row, [&, warp = warps.back().get()] { warp->warp(faces, frame.pixels()); }, {}});
    }
  };
  FilterSettings filter = rig.filter;
  filter.table = TableForm::kFast;
  add_table("ewa fast", filter, {Cpu::kAvx512, Cpu::kAvx2, Cpu::kSse4, Cpu::kNeon, Cpu::kScalar});
  SkippingBench skipping(rig, *tables.back(), faces, map.in_image, alone);
  for (Lap& lap : skipping.laps()) laps.push_back(std::move(lap));
  std::vector<std::unique_ptr<NativeBench>> native;
  for (const Cpu cpu : {Cpu::kAvx512, Cpu::kAvx2}) {
    if (!supported(cpu)) continue;
    native.push_back(std::make_unique<NativeBench>(rig, *tables.back(), faces, alone, cpu));
    for (Lap& lap : native.back()->laps()) laps.push_back(std::move(lap));
  }
  filter.table = TableForm::kPrecise;
  add_table("ewa precise", filter, {Cpu::kAvx512, Cpu::kAvx2, Cpu::kSse4, Cpu::kNeon});
  std::vector<ImageBuffer> deep_buffers;
  std::vector<Image> deep_faces;
  for (const Image& face : faces) {
    deep_buffers.emplace_back(PixelFormat::kRgbPlanar16, face.size);
    convert(face, deep_buffers.back().pixels());
    deep_faces.push_back(deep_buffers.back().pixels());
  }
  ImageBuffer deep_frame(PixelFormat::kRgbPlanar16, rig.frame.size);
  const WarpTable& precise = *tables.back();
  for (const Cpu cpu : {Cpu::kAvx512, Cpu::kAvx2, Cpu::kSse4, Cpu::kNeon}) {
    if (!supported(cpu)) continue;
    const auto add = [&](const char* name, std::span<const Image> in, ImageBuffer& out, bool light) {
      warps.push_back(make_table_warp(precise, cpu, alone, {.linear_light = light}));
      laps.push_back({{fmt::format("ewa precise {}, {}", name, cupola::name(cpu)), 0, 0, 0, -1, -1},
                      [&, in, warp = warps.back().get()] { warp->warp(in, out.pixels()); },
                      {}});
    };
    add("16 bits", deep_faces, deep_frame, false);
    add("16 bits to 8, dithered", deep_faces, frame, false);
    add("in light", faces, frame, true);
  }
  add_table("ewa paper fast", paper_preset(), {Cpu::kAvx512, Cpu::kAvx2, Cpu::kSse4, Cpu::kNeon});
  for (const Method method :
       {Method::kEwaScan, Method::kEwaScanInteger, Method::kEwaPyramid, Method::kTwoPass, Method::kTrilinear,
        Method::kSummedArea, Method::kBilinear, Method::kNearest}) {
    warps.push_back(make_frame_warp(rig, method, Cpu::kScalar, alone));
    laps.push_back({{std::string(kMethodNames[static_cast<std::size_t>(method)]), 0, 0,
                     static_cast<double>(warps.back()->table_bytes()) / in_image, -1, -1},
                    [&, warp = warps.back().get()] { warp->warp(faces, frame.pixels()); },
                    {}});
  }
  // Interleaved, so that whatever else the machine does falls on all alike.
  for (int round = 0; round < rounds; ++round) {
    for (Lap& lap : laps) lap.times.push_back(cpu_milliseconds(lap.work));
  }
  Speed speed{map.in_image, {}};
  for (Lap& lap : laps) {
    lap.row.milliseconds = median(lap.times);
    lap.row.ns_per_pixel = lap.row.milliseconds * 1e6 / in_image;
    speed.rows.push_back(lap.row);
  }
  return speed;
}

}  // namespace cupola
