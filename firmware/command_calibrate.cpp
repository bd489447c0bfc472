// cupola calibrate: lenses and poses of a rig's cameras, from pictures of a printed board.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <cstdio>
#include <mutex>

#include "firmware/calibration_report.h"
#include "firmware/command.h"
#include "firmware/progress.h"
#include "firmware/show.h"
#include "pipeline/calibrate/calibration_file.h"
#include "pipeline/calibrate/opencv.h"
#include "pipeline/calibrate/rig_calibration.h"
#include "pipeline/calibrate/rig_text.h"
#include "pipeline/calibrate/shot_folder.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/file_bytes.h"
#include "pipeline/frame/still.h"

namespace cupola {
namespace {

class CalibrateCommand final : public Command {
 public:
  explicit CalibrateCommand(CLI::App& program)
      : Command(
            program, "calibrate", "Find lenses and poses of a rig's cameras from pictures of a printed board",
            "  cupola calibrate --rig my-dome.toml --from shots --board 9x6 --square-mm 25\n"
            "      reads shots/front/0001.png, shots/left/0001.png, ...; a number is the same moment on all\n"
            "      cameras. Writes my-dome-calibrated.toml and a my-dome-calibrated-VIEW.yml a camera\n") {
    options().add_option("--rig", rig_, "The rig's file")->required()->type_name("FILE");
    options()
        .add_option("--from", from_, "The folder of pictures, VIEW/SHOT.png")
        ->required()
        ->type_name("DIR");
    options()
        .add_option("--board", board_, "The chessboard's inner corners, where four squares meet")
        ->required()
        ->type_name("9x6");
    options()
        .add_option("--square-mm", square_mm_, "Side of the board's squares, measured on the print")
        ->required()
        ->type_name("MM");
    options()
        .add_option("--model", model_, "Of the lenses: radial or fisheye; by default whichever fits better")
        ->check(CLI::IsMember({"radial", "fisheye"}))
        ->type_name("NAME");
    options()
        .add_option("--out", out_, "The rig file to write, beside the rig; by default RIG-calibrated.toml")
        ->type_name("FILE");
    options().add_flag("--json", json_, "One JSON object instead of a table");
  }

  int run() override;

 private:
  std::filesystem::path target(const Rig& rig) const;
  void write(const Rig& rig, const RigCalibration& calibration) const;

  std::string rig_;
  std::string from_;
  std::string board_;
  double square_mm_ = 0.0;
  std::string model_;
  std::string out_;
  bool json_ = false;
};

struct Looked {  // at all pictures
  std::vector<Sighting> sightings;
  std::vector<Size> sizes;  // of the views' pictures; 0 x 0 without any
};

Looked look(const ShotFolder& folder, const Rig& rig, const Board& board, WorkerPool& pool) {
  std::vector<Sighting> found(folder.pictures.size());
  std::vector<Size> sizes(folder.pictures.size());
  Progress progress("pictures", static_cast<std::int64_t>(folder.pictures.size()));
  std::mutex mutex;
  std::int64_t done = 0;
  pool.run(static_cast<int>(folder.pictures.size()), [&](int picture) {
    const auto p = static_cast<std::size_t>(picture);
    const ImageBuffer pixels = read_still(folder.pictures[p].file);
    sizes[p] = pixels.size();
    find_board(pixels.pixels(), board, found[p]);
    found[p].camera = folder.pictures[p].camera;
    found[p].shot = folder.pictures[p].shot;
    const std::lock_guard lock(mutex);
    progress.show(++done);
  });
  Looked looked;
  looked.sizes.resize(rig.views.size());
  for (std::size_t p = 0; p < found.size(); ++p) {
    const auto camera = static_cast<std::size_t>(found[p].camera);
    const Size wanted = looked.sizes[camera] == Size{} ? rig.views[camera].size : looked.sizes[camera];
    if (wanted.width != 0 && !(wanted == sizes[p])) {
      throw InputError(fmt::format("{}: expected a picture of {} x {} texels, as {}, not {} x {}",
                                   folder.pictures[p].file.string(), wanted.width, wanted.height,
                                   looked.sizes[camera] == Size{} ? "the rig file says" : "those before it",
                                   sizes[p].width, sizes[p].height));
    }
    looked.sizes[camera] = sizes[p];
    if (!found[p].corners.empty()) looked.sightings.push_back(std::move(found[p]));
  }
  return looked;
}

// No board anywhere: one of the sizes that people mean by mistake may be there.
[[noreturn]] void refuse_board(const ShotFolder& folder, const Board& board, const std::string& from) {
  std::string hint = "is the whole board in them, flat, sharp and evenly lit?";
  constexpr std::size_t kTries = 8;
  const std::size_t step = std::max<std::size_t>(1, folder.pictures.size() / kTries);
  for (std::size_t p = 0; p < folder.pictures.size(); p += step) {
    const ImageBuffer pixels = read_still(folder.pictures[p].file);
    for (const int more : {-1, 1, -2, 2}) {
      const Board other{board.columns + more, board.rows + more, board.square_m};
      Sighting sighting;
      if (other.columns < 3 || other.rows < 3 || !find_board(pixels.pixels(), other, sighting)) continue;
      hint = fmt::format("{} shows one of {} x {}: try --board {}x{}", folder.pictures[p].file.string(),
                         other.columns, other.rows, other.columns, other.rows);
      p = folder.pictures.size() - 1;
      break;
    }
  }
  throw InputError(fmt::format("{}: expected a board of {} x {} inner corners in {} pictures, found none; {}",
                               from, board.columns, board.rows, folder.pictures.size(), hint));
}

std::string text_of(const std::filesystem::path& file) {
  FileBytes bytes;
  read_file(file, "a rig file", bytes);
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

std::filesystem::path CalibrateCommand::target(const Rig& rig) const {
  if (!out_.empty()) {
    if (std::filesystem::path(out_).extension() != ".toml")
      throw InputError(fmt::format("--out {}: expected a name that ends in .toml", out_));
    std::error_code error;
    const std::filesystem::path folder = std::filesystem::absolute(out_).parent_path();
    if (!std::filesystem::equivalent(folder, std::filesystem::absolute(rig.file).parent_path(), error))
      throw InputError(
          fmt::format("--out {}: expected a name in the rig's folder, whose files it names", out_));
    return out_;
  }
  return rig.file.parent_path() / (rig.file.stem().string() + "-calibrated.toml");
}

void CalibrateCommand::write(const Rig& rig, const RigCalibration& calibration) const {
  const std::filesystem::path out = target(rig);
  std::vector<ViewKeys> keys(rig.views.size());
  for (std::size_t c = 0; c < keys.size(); ++c) {
    const CameraCalibration& camera = calibration.cameras[c];
    if (!camera.has_lens) continue;
    const std::string name = fmt::format("{}-{}.yml", out.stem().string(), camera.view.name);
    AtomicFile file(out.parent_path() / name);
    file.write(calibration_text(camera.view, camera.rms));
    file.commit();
    keys[c].calibration = name;
    if (!camera.joined) continue;
    keys[c].position_m = camera.position_m;
    if (camera.turn_deviation_deg == 0.0) continue;  // the anchor
    keys[c].forward = camera.view.forward;
    keys[c].up = camera.view.up;
  }
  AtomicFile file(out);
  file.write(rewrite_views(text_of(rig.file), rig.file, keys, rig.world_from_lens));
  file.commit();
  load_rig(out, overrides());  // what cannot be read again must not go unnoticed
  if (!json_) fmt::print("written: {}\n", out.string());
}

int CalibrateCommand::run() {
  const Board board = parse_board(board_, square_mm_);
  const Rig rig = load_named_rig(rig_, overrides());
  target(rig);  // before the work
  std::vector<std::string> views;
  for (const View& view : rig.views) views.push_back(view.name);
  const ShotFolder folder = list_shots(from_, views);
  if (!have_opencv()) throw Failure("cupola calibrate: built without OpenCV's calib3d (CUPOLA_CALIBRATE)");
  WorkerPool pool(threads());
  const Looked looked = look(folder, rig, board, pool);
  if (looked.sightings.empty()) refuse_board(folder, board, from_);
  std::optional<Distortion> model;
  if (!model_.empty()) model = model_ == "fisheye" ? Distortion::kFisheye : Distortion::kRadialTangential;
  const RigCalibration calibration =
      calibrate_rig(rig, board, looked.sightings, folder.shots, looked.sizes, model, pool);
  fmt::print("{}", json_ ? calibration_json(calibration, rig, folder.shots)
                         : calibration_table(calibration, rig, folder.shots));
  bool any = false;
  for (const CameraCalibration& camera : calibration.cameras) any = any || camera.has_lens;
  if (any) write(rig, calibration);
  for (const std::string& trouble : calibration.troubles) fmt::print(stderr, "{}\n", trouble);
  return calibration.troubles.empty() ? 0 : 1;
}

}  // namespace

std::unique_ptr<Command> make_calibrate_command(CLI::App& program) {
  return std::make_unique<CalibrateCommand>(program);
}

}  // namespace cupola
