// Writes the seeds of the fuzzers: a folder each in FOLDER.
// SPDX-License-Identifier: MIT
#include <cstdio>
#include <string>
#include <utility>

#include "firmware/show_position.h"
#include "hal/camera/recording_file.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/still.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/table_packing.h"
#include "tests/frame/picture_files.h"
#include "tests/fuzz/table_seed.h"
#include "tests/hal/test_jpeg.h"

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
  for (const int down : {1, 2}) {
    for (const bool tables : {false, true}) {
      test::JpegMaking making;
      making.width = 23;
      making.height = 17;
      making.down = down;
      making.huffman_tables = tables;
      const auto jpeg =
          test::make_jpeg(making, [](int c, int x, int y) { return 60 + 20 * c + 3 * x + 2 * y; });
      write_text(std::filesystem::path(words[1]) / "camera_jpeg" /
                     (std::string(down == 2 ? "420" : "422") + (tables ? ".jpg" : "_bare.jpg")),
                 std::string(jpeg.begin(), jpeg.end()));
    }
  }
  const std::filesystem::path recordings = std::filesystem::path(words[1]) / "recording";
  std::filesystem::create_directories(recordings);
  {
    RecordingWriter writer(recordings / "all.camera");
    const std::string bytes(70, 'x');
    for (const RecordKind kind : {RecordKind::kRefused, RecordKind::kStarted, RecordKind::kFrame,
                                  RecordKind::kDamaged, RecordKind::kLost}) {
      CameraRecord record;
      record.kind = kind;
      record.trouble.step = "step";
      record.frame.width = 4;
      record.frame.height = 6;
      record.frame.planes[0] = {reinterpret_cast<const std::uint8_t*>(bytes.data()), 8, 48, -1, 0};
      writer.append(record);
    }
  }
  const std::pair<const char*, std::size_t> kinds[] = {
      // tag, bytes of a frame of 2 x 2
      {"420jpeg", 6}, {"420mpeg2", 6}, {"420paldv", 6}, {"422", 8},     {"444", 12},
      {"mono", 4},    {"420p10", 12},  {"422p12", 16},  {"444p16", 24}, {"mono12", 8}};
  for (const auto& [tag, bytes] : kinds) {
    const std::string start = std::string("YUV4MPEG2 W2 H2 F25:1 Ip A1:1 C") + tag + " XCOLORRANGE=FULL\n";
    write_text(videos / (std::string(tag) + ".y4m"), start + "FRAME\n" + std::string(bytes, 'x'));
  }
  ShowPosition position;
  position.show = "demo";
  position.cue_name = "demo";
  position.at = {"2f1c9f4a-0000-4000-8000-000000000000", std::chrono::seconds(5), std::chrono::seconds(7)};
  write_text(std::filesystem::path(words[1]) / "position" / "playing.json", position_text(position));
  using namespace std::string_literals;
  const std::filesystem::path osc = std::filesystem::path(words[1]) / "osc";
  const std::string fade = "/cupola/fade\0\0\0\0,sf\0out\0@ \0\0"s;
  const std::string all = "/any\0\0\0\0,ihdTFIS\0\0\0\0\0\0\0\7\0\0\0\0\0\0\0\7?\xf8\0\0\0\0\0\0s\0\0\0"s;
  write_text(osc / "fade", fade);
  write_text(osc / "all", all);
  write_text(osc / "pattern", "/c[!b-t]p*/{pause,play-}?[a]us*\0,\0\0\0"s);
  write_text(osc / "token", "/*/the-token/{go}\0\0\0,\0\0\0"s);
  write_text(osc / "bundle", "#bundle\0\0\0\0\0\0\0\0\1\0\0\0\x1c"s + fade + "\0\0\0\x2c"s + all);
  const std::filesystem::path tables = std::filesystem::path(words[1]) / "table";
  std::filesystem::create_directories(tables);
  WorkerPool pool(1);
  const WarpTable table = build_warp_table(table_fuzz_rig(), pool);
  AtomicFile file(tables / "small.table");
  file.write(table.memory.bytes());
  file.commit();
  AtomicFile packed(tables / "packed.zst");
  packed.write(pack_table(table.memory.bytes(), pool));
  packed.commit();
}
