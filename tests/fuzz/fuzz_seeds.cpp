// Writes the seeds of the fuzzers: FOLDER/still, FOLDER/table and FOLDER/y4m.
// SPDX-License-Identifier: MIT
#include <cstdio>
#include <string>
#include <utility>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/still.h"
#include "pipeline/warp/table_build.h"
#include "tests/frame/picture_files.h"
#include "tests/fuzz/table_seed.h"

int main(int count, char** words) {
  using namespace cupola;
  if (count != 2) {
    std::fputs("usage: fuzz_seeds FOLDER\n", stderr);
    return 2;
  }
  const std::filesystem::path stills = std::filesystem::path(words[1]) / "still";
  const std::filesystem::path videos = std::filesystem::path(words[1]) / "y4m";
  const ImageBuffer image = smooth_picture(PixelFormat::kRgbPlanar8, {19, 11});
  write_text(stills / "rgb.png", png_file(image.pixels()));
  write_text(stills / "interlaced.png", png_file(image.pixels(), true));
  write_png(stills / "deep.png", smooth_picture(PixelFormat::kRgb16, {9, 5}).pixels());
  write_text(stills / "palette.png", kPngSignature + png_header(2, 1, 4, 3) + png_chunk("PLTE", "abcdef") +
                                         png_data(std::string("\0\x10", 2)) + kPngEnd);
  write_text(stills / "grey_alpha.png",
             kPngSignature + png_header(1, 1, 16, 4) + png_data(std::string(5, '\0')) + kPngEnd);
  for (const bool progressive : {false, true}) {
    for (const int components : {1, 3, 4}) {
      write_text(stills / (std::to_string(components) + (progressive ? "p.jpg" : ".jpg")),
                 jpeg_file(image.pixels(), {.components = components, .progressive = progressive}));
    }
  }
  for (const TiffKind& kind : kTiffKinds)
    write_tiff(stills / (std::string(kind.name) + ".tif"), image.pixels(), kind);
  const std::pair<const char*, std::size_t> kinds[] = {
      // tag, bytes of a frame of 2 x 2
      {"420jpeg", 6}, {"420mpeg2", 6}, {"420paldv", 6}, {"422", 8},     {"444", 12},
      {"mono", 4},    {"420p10", 12},  {"422p12", 16},  {"444p16", 24}, {"mono12", 8}};
  for (const auto& [tag, bytes] : kinds) {
    const std::string start = std::string("YUV4MPEG2 W2 H2 F25:1 Ip A1:1 C") + tag + " XCOLORRANGE=FULL\n";
    write_text(videos / (std::string(tag) + ".y4m"), start + "FRAME\n" + std::string(bytes, 'x'));
  }
  const std::filesystem::path tables = std::filesystem::path(words[1]) / "table";
  std::filesystem::create_directories(tables);
  WorkerPool pool(1);
  const WarpTable table = build_warp_table(table_fuzz_rig(), pool);
  AtomicFile file(tables / "small.table");
  file.write(table.memory.bytes());
  file.commit();
}
