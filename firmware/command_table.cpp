// cupola table: what a rig's warp table holds, what it reads and how exact it is.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>

#include "firmware/command.h"
#include "firmware/frame_error.h"
#include "firmware/held_budget.h"
#include "firmware/pictures.h"
#include "firmware/show.h"
#include "hal/time/clock.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/still.h"
#include "pipeline/optics/frame_map.h"
#include "pipeline/source/generated_source.h"
#include "pipeline/warp/ewa_exact.h"
#include "pipeline/warp/ewa_warp.h"
#include "pipeline/warp/table_packing.h"

namespace cupola {
namespace {

class TableCommand final : public Command {
 public:
  explicit TableCommand(CLI::App& program)
      : Command(program, "table", "Say what a rig's warp table holds and how exact it is",
                "  cupola table --rig omnimax\n"
                "  cupola table --rig omnimax --picture needed.png --map views.png\n"
                "  cupola table --rig domemaster-4k-5 --face-size 2048 --set filter.table=precise\n") {
    options()
        .add_option("--rig", rig_, "The rig's file, or the name of one in config/rigs")
        ->required()
        ->type_name("FILE");
    options()
        .add_option("--face-size", face_size_, "Sides of the faces, texels, where the rig does not say")
        ->check(CLI::Range(1, 16384))
        ->type_name("N");
    options()
        .add_option("--picture", picture_, "Draw the unfolded cube, dark where nothing is needed")
        ->type_name("OUT.png");
    options()
        .add_option("--map", map_, "Draw the frame in the colours of the views that feed it")
        ->type_name("OUT.png");
    options().add_option("--out", out_, "Write the table as the cache keeps it")->type_name("FILE");
    offer_cache();
  }

  int run() override;

 private:
  void draw_cube(const Rig& rig, std::span<const NeededRegion> needed, WorkerPool& pool) const;

  std::string rig_;
  int face_size_ = 1024;
  std::string picture_;
  std::string map_;
  std::string out_;
};

void TableCommand::draw_cube(const Rig& rig, std::span<const NeededRegion> needed, WorkerPool& pool) const {
  GeneratedSource source(rig.views, rig.world_from_lens, make_world("demo"), 60.0, pool);
  std::vector<NeededRegion> all;
  for (const View& view : rig.views) all.push_back(NeededRegion::all(view.size));
  source.prepare(all);
  FaceSet set;
  source.fetch(0, set);
  const ImageBuffer picture = unfolded(rig, set.faces, needed);
  write_png(picture_, picture.pixels());
}

int TableCommand::run() {
  const Cpu on = cpu();
  for (const std::string& out : {picture_, map_}) expect_png_name(out);
  WorkerPool pool(threads());
  Rig rig = load_named_rig(rig_, overrides());
  std::vector<Size> sizes;
  for (const View& view : rig.views) {
    sizes.push_back(view.size == Size{} ? Size{face_size_, face_size_} : view.size);
  }
  set_view_sizes(rig, sizes);

  MonotonicClock clock;
  TableCache tables = cache();
  hold_budget(rig, false, on, pool, &tables);
  const auto began = clock.now();
  const WarpTable table = tables.table(rig, pool);
  const double took_ms = std::chrono::duration<double, std::milli>(clock.now() - began).count();
  warn_about(tables);
  const FrameMap map = map_frame(rig, pool);
  fmt::print("{}: {} x {} pixels, {} in the image\n", rig.file.string(), rig.frame.size.width,
             rig.frame.size.height, grouped(map.in_image));
  fmt::print("table       {} bytes, {} {:.1f} ms\n", grouped(static_cast<std::int64_t>(table.bytes())),
             tables.found() > 0 ? "from the cache in" : "built in", took_ms);
  std::vector<std::byte> packed;
  if (rig.filter.table == TableForm::kCompact) {
    packed = pack_table(table.memory.bytes(), pool);
    fmt::print("packed      {} bytes\n", grouped(static_cast<std::int64_t>(packed.size())));
  }
  fmt::print("taps        {}, {:.2f} a pixel\n", grouped(table.taps),
             static_cast<double>(table.taps) /
                 std::max<double>(1.0, static_cast<double>(map.in_image - map.uncovered)));
  for (std::size_t i = 0; i < rig.views.size(); ++i) {
    const View& view = rig.views[i];
    const double all = static_cast<double>(view.size.width) * view.size.height;
    const std::int64_t texels = table.needed[i].texels();
    fmt::print("needs       {} of {}'s {} x {} texels, {:.1f} %\n", grouped(texels), view.name,
               view.size.width, view.size.height, 100.0 * static_cast<double>(texels) / all);
  }
  fmt::print("uncovered   {} pixels\n", grouped(map.uncovered));

  const std::vector<ImageBuffer> buffers = noise_faces(rig);
  std::vector<Image> faces;
  for (const ImageBuffer& face : buffers) faces.push_back(face.pixels());
  ImageBuffer frame(PixelFormat::kRgbPlanar8, rig.frame.size);
  make_table_warp(table, on, pool)->warp(faces, frame.pixels());
  const FrameError error = frame_error(map, as_const(frame.pixels()), ewa_exact_frame(rig, faces, pool));
  fmt::print("error       {:.3f} steps RMS, {:.3f} at most, on noise, against ewa-exact\n", error.rms,
             error.max);

  if (!picture_.empty()) draw_cube(rig, table.needed, pool);
  if (!out_.empty()) {
    AtomicFile file(out_);
    file.write(packed.empty() ? table.memory.bytes() : packed);
    file.commit();
  }
  if (!map_.empty()) {
    const ImageBuffer picture = coloured(map);
    write_png(map_, picture.pixels());
  }
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_table_command(CLI::App& program) {
  return std::make_unique<TableCommand>(program);
}

}  // namespace cupola
