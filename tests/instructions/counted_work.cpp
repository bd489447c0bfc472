// One piece of work for callgrind to count: a table built, or one frame warped, all of it in counted_work().
//
//   counted_work table|scalar|sse4|avx2 gaussian|robidoux|optimal
//
// Prints how many pixels are in the image, 0 where this machine has not the instruction set. Noise from four
// faces of 128 x 128 texels to 246 x 180 pixels, one thread.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <cstdio>
#include <functional>
#include <random>
#include <string_view>

#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_build.h"

// By this name `--toggle-collect` finds it.
extern "C" [[gnu::noinline]] void counted_work(const std::function<void()>& work) {
  work();
}

namespace cupola {
namespace {

Rig rig_of(std::string_view kernel) {
  Rig rig;
  rig.frame.size = {246, 180};
  rig.frame.center = {123.0, 123.0};
  rig.frame.radius = 123.0;
  rig.frame.lens = omnimax_c430();
  for (const char* name : {"front", "left", "right", "top"}) {
    View view;
    view.name = name;
    named_pose(name, view);
    view.size = {128, 128};
    rig.views.push_back(view);
  }
  rig.filter = kernel == "optimal"    ? optimal_filter()
               : kernel == "robidoux" ? robidoux_filter()
                                      : default_gaussian();
  return rig;
}

std::vector<ImageBuffer> noise(const Rig& rig) {
  std::vector<ImageBuffer> faces;
  std::mt19937 random(1);
  for (const View& view : rig.views) {
    ImageBuffer& face = faces.emplace_back(PixelFormat::kRgbPlanar8, view.size);
    for (int row = 0; row < 3 * view.size.height; ++row) {
      std::uint8_t* texels = face.pixels().samples<std::uint8_t>(row % 3, row / 3);
      std::generate_n(texels, view.size.width, [&] { return static_cast<std::uint8_t>(random()); });
    }
  }
  return faces;
}

int run(std::string_view work, std::string_view kernel) {
  const Rig rig = rig_of(kernel);
  WorkerPool pool(1);
  WarpTable table;
  const auto build = [&] { table = build_warp_table(rig, pool); };
  if (work == "table") {
    counted_work(build);
    std::printf("%lld\n", static_cast<long long>(table.pixels_in_image));
    return 0;
  }
  const auto cpu = static_cast<Cpu>(std::ranges::find(kCpuNames, work) - std::begin(kCpuNames));
  if (cpu > Cpu::kNeon) return 2;
  if (!supported(cpu)) {
    std::printf("0\n");
    return 0;
  }
  build();
  const std::vector<ImageBuffer> faces = noise(rig);
  std::vector<Image> images;
  for (const ImageBuffer& face : faces) images.push_back(face.pixels());
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  const auto warp = make_table_warp(table, cpu, pool);
  warp->warp(images, frame.pixels());  // whatever is done once
  counted_work([&] { warp->warp(images, frame.pixels()); });
  std::printf("%lld\n", static_cast<long long>(table.pixels_in_image));
  return 0;
}

}  // namespace
}  // namespace cupola

int main(int count, char** arguments) {
  return count == 3 ? cupola::run(arguments[1], arguments[2]) : 2;
}
