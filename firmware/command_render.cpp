// cupola render: a show's frames into numbered files, or as one video.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <nlohmann/json.hpp>
#include <optional>

#include "firmware/command.h"
#include "firmware/face_options.h"
#include "firmware/interrupt.h"
#include "firmware/progress.h"
#include "firmware/render_state.h"
#include "firmware/show_frames.h"
#include "firmware/skip_report.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/frame/numbered_frames.h"
#include "pipeline/frame/y4m_writer.h"

namespace cupola {
namespace {

// Both inclusive, counted from 0.
struct FrameRange {
  std::int64_t first = 0;
  std::int64_t last = 0;
};

FrameRange parse_range(const std::string& text) {
  long long first = 0;
  long long last = 0;
  int used = 0;
  const int fields = std::sscanf(text.c_str(), "%12lld-%12lld%n", &first, &last, &used);
  if (fields == 2 && static_cast<std::size_t>(used) == text.size() && first >= 0 && last >= first)
    return {first, last};
  if (text.find_first_not_of("0123456789") == std::string::npos && !text.empty() && text.size() < 13) {
    return {std::stoll(text), std::stoll(text)};
  }
  throw InputError(fmt::format("--frames {}: expected A-B, both included and counted from 0", text));
}

class RenderCommand final : public Command {
 public:
  explicit RenderCommand(CLI::App& program)
      : Command(program, "render", "Render a show to numbered pictures or to a Y4M video",
                "  cupola render demo --out frames --frames 0-59\n"
                "  cupola render my-show.toml --rig domemaster-4k-5 --out frames\n"
                "  cupola render --rig omnimax --world tree --out still --faces\n"
                "  cupola render demo --out - | ffmpeg -i - -c:v libx264 -crf 16 demo.mp4\n"),
        faces_(options(), "--atlas-faces") {
    options().add_option("show", show_, "The show's file, or the name of one in config/shows");
    options()
        .add_option("--rig", rig_, "Another rig than the show's; needed where there is no show")
        ->type_name("FILE");
    options()
        .add_option("--out", out_,
                    "A folder for NAME_000001.png ..., FILE.y4m, or - for Y4M to standard output")
        ->required()
        ->type_name("DIR");
    options()
        .add_option("--frames", frames_, "Frames from A to B, both included and counted from 0")
        ->type_name("A-B");
    options()
        .add_option("--shard", shard_, "Every N-th frame only, beginning with the K-th, K from 1 to N")
        ->type_name("K/N");
    options()
        .add_option("--rate", rate_, "Frames a second where there is no show; 60 unless given")
        ->check(CLI::Range(0.01, 1000.0))
        ->type_name("HZ");
    options().add_flag("--faces", with_faces_, "Write the faces too, as NAME_VIEW_000001.png");
    options()
        .add_option("--format", format_, "Of numbered pictures: png, or exr, linear light in half floats")
        ->check(CLI::IsMember({"png", "exr"}))
        ->type_name("NAME");
    options()
        .add_option("--bits", bits_,
                    "Of a sample in PNG files, 8 or 16, those of the faces unless given; in videos 8 or 10")
        ->check(CLI::IsMember({8, 10, 16}))
        ->type_name("N");
    options()
        .add_option("--stats", stats_, "Write what was done and what was skipped as JSON")
        ->type_name("FILE");
    offer_cache();
  }

  int run() override;

 private:
  Show show() const;
  FrameRange range(const ShowFrames& frames) const;
  // The frames of this shard, in rising order.
  std::vector<std::int64_t> numbers(const FrameRange& range) const;
  void fetch(ShowFrames& frames, std::int64_t number) const;
  // Both give what the warps did and left out. `key` stands for all that bears on the pixels.
  WarpWork render_files(ShowFrames& frames, const std::string& name, std::span<const std::int64_t> all,
                        const std::string& key, WorkerPool& pool) const;
  WarpWork render_video(ShowFrames& frames, std::span<const std::int64_t> numbers) const;

  FaceOptions faces_;
  std::string show_;
  std::string rig_;
  std::string out_;
  std::string frames_;
  std::string shard_ = "1/1";
  double rate_ = 60.0;
  bool with_faces_ = false;
  std::string format_ = "png";
  int bits_ = 0;
  std::string stats_;
};

Show RenderCommand::show() const {
  if (!show_.empty()) {
    if (faces_.given()) throw InputError("render: expected a show, or a rig and faces, not both");
    return load_show(show_, overrides(), rig_);
  }
  if (rig_.empty()) throw InputError("render: expected a show, or --rig with --view, --atlas or --world");
  Show show;
  show.rig = load_named_rig(rig_, overrides());
  show.name = show.rig.file.stem().string();
  show.cues.push_back(faces_.cue(show.rig));
  show.cues.front().rate = rate_;
  return show;
}

std::chrono::nanoseconds time_of(std::int64_t number, double rate) {
  return std::chrono::nanoseconds(std::llround(1e9 * static_cast<double>(number) / rate));
}

FrameRange RenderCommand::range(const ShowFrames& frames) const {
  const std::optional<std::chrono::nanoseconds> length = frames.timeline().length();
  std::optional<std::int64_t> count;
  if (length)
    count =
        std::max<std::int64_t>(1, std::llround(1e-9 * static_cast<double>(length->count()) * frames.rate()));
  if (frames_.empty()) {
    if (count) return {0, *count - 1};
    if (show_.empty()) return {0, 0};
    throw InputError(fmt::format("{}: the show never ends; expected --frames A-B", show_));
  }
  const FrameRange range = parse_range(frames_);
  if (count && range.last >= *count) {
    throw InputError(fmt::format("--frames {}: the show has frames 0 to {}", frames_, *count - 1));
  }
  return range;
}

std::vector<std::int64_t> RenderCommand::numbers(const FrameRange& range) const {
  int shard = 0;
  int shards = 0;
  char rest = 0;
  if (std::sscanf(shard_.c_str(), "%9d/%9d%c", &shard, &shards, &rest) != 2 || shard < 1 || shard > shards) {
    throw InputError(fmt::format("--shard {}: expected K/N, K from 1 to N", shard_));
  }
  std::vector<std::int64_t> numbers;
  for (std::int64_t number = range.first; number <= range.last; ++number) {
    if ((number - range.first) % shards == shard - 1) numbers.push_back(number);
  }
  return numbers;
}

void RenderCommand::fetch(ShowFrames& frames, std::int64_t number) const {
  const std::chrono::nanoseconds time = time_of(number, frames.rate());
  const ShowFrames::Change change = frames.advance({time, time});
  if (change == ShowFrames::Change::kFailed) throw InputError(frames.trouble());
}

WarpWork RenderCommand::render_files(ShowFrames& frames, const std::string& name,
                                     std::span<const std::int64_t> all, const std::string& key,
                                     WorkerPool& pool) const {
  const StillFormat still = format_ == "exr" ? StillFormat::kExr : StillFormat::kPng;
  const NumberedFrames files(out_, name, still);
  std::string shard = shard_;
  std::replace(shard.begin(), shard.end(), '/', '-');
  RenderState state(std::filesystem::path(out_) / fmt::format(".{}.{}.render", name, shard), key);
  std::vector<std::int64_t> numbers;
  for (const std::int64_t number : all) {
    if (!state.done(number, files.path_of(number))) numbers.push_back(number);
  }
  const auto before = static_cast<std::int64_t>(all.size() - numbers.size());
  if (before > 0)
    fmt::print(stderr, "render: {}: {} of {} frames are there; going on\n", out_, before, all.size());
  std::vector<NumberedFrames> face_files;
  if (with_faces_) {
    for (const View& view : frames.rig().views) face_files.emplace_back(out_, name + "_" + view.name, still);
  }
  const bool deep =
      still == StillFormat::kExr || (bits_ == 0 ? frames.format() == PixelFormat::kRgbPlanar16 : bits_ == 16);
  const PixelFormat format = deep ? PixelFormat::kRgb16 : PixelFormat::kRgb8;
  std::vector<ImageBuffer> batch;  // warped one after the other, compressed side by side
  for (int i = 0; i < std::min(pool.threads(), 8); ++i) batch.emplace_back(format, frames.frame_size());
  Progress progress("render", static_cast<std::int64_t>(all.size()));
  WarpWork work;
  // Every buffer holds what was warped into it a batch ago; whole batches are of one size.
  const int age = static_cast<int>(batch.size());
  for (std::size_t done = 0; done < numbers.size();) {
    const std::size_t count = std::min(batch.size(), numbers.size() - done);
    for (std::size_t i = 0; i < count; ++i) {
      if (interrupted())
        throw Failure(fmt::format("{}: interrupted after {} of {} frames", out_,
                                  static_cast<std::size_t>(before) + done, all.size()));
      fetch(frames, numbers[done + i]);
      work += frames.warp(batch[i].pixels(), done > 0 ? age : 0);
      if (with_faces_) {
        pool.run(static_cast<int>(face_files.size()), [&](int view) {
          const auto v = static_cast<std::size_t>(view);
          face_files[v].write(numbers[done + i], frames.faces().faces[v]);
        });
      }
    }
    pool.run(static_cast<int>(count), [&](int i) {
      const auto at = static_cast<std::size_t>(i);
      files.write(numbers[done + at], as_const(batch[at].pixels()));
    });
    for (std::size_t i = 0; i < count; ++i) state.add(numbers[done + i], files.path_of(numbers[done + i]));
    done += count;
    progress.show(before + static_cast<std::int64_t>(done));
  }
  state.finish();
  return work;
}

WarpWork RenderCommand::render_video(ShowFrames& frames, std::span<const std::int64_t> numbers) const {
  if (with_faces_) throw InputError("--faces: expected a folder as --out");
  if (bits_ == 16) throw InputError("--bits 16: expected a folder as --out; videos have 8 or 10");
  if (format_ != "png")
    throw InputError(fmt::format("--format {}: expected a folder as --out; videos are Y4M", format_));
  expect_pipe(out_);
  const bool deep = bits_ == 10;
  Y4mWriter video(out_, frames.frame_size(), frame_rate(frames.rate()), deep ? 10 : 8);
  ImageBuffer frame(deep ? PixelFormat::kRgbPlanar16 : PixelFormat::kRgbPlanar8, frames.frame_size());
  Progress progress("render", static_cast<std::int64_t>(numbers.size()));
  WarpWork work;
  std::int64_t done = 0;
  for (const std::int64_t number : numbers) {
    if (interrupted())
      throw Failure(fmt::format("{}: interrupted after {} of {} frames", out_, done, numbers.size()));
    fetch(frames, number);
    work += frames.warp(frame.pixels(), done > 0 ? 1 : 0);
    video.write(as_const(frame.pixels()));
    progress.show(++done);
  }
  video.finish();
  return work;
}

int RenderCommand::run() {
  const Cpu on = cpu();
  if (format_ == "exr" && bits_ == 8)
    throw InputError("--bits 8: expected --format png; EXR has half floats");
  if (bits_ == 10 && !is_video_name(out_))
    throw InputError("--bits 10: expected FILE.y4m or - as --out; pictures have 8 or 16");
  WorkerPool pool(threads());
  Show what = show();
  for (Cue& cue : what.cues) cue.wait = false;  // nobody is there to say go
  for (const Cue& cue : what.cues) {
    if (with_faces_ && cue.finished) throw InputError(fmt::format("--faces: cue {} has none", cue.name));
  }
  TableCache tables = cache();
  ShowFrames frames(what, Method::kEwa, on, pool, with_faces_, &tables);
  warn_about(tables);
  const std::vector<std::int64_t> due = numbers(range(frames));
  std::string said = fmt::format("{} {} {} {}\n", CUPOLA_VERSION, with_faces_, bits_, format_);
  for (const Cue& cue : what.cues) said += all_of(cue);
  const WarpWork work = is_video_name(out_)
                            ? render_video(frames, due)
                            : render_files(frames, what.name, due, render_key(said, frames.key()), pool);
  if (stats_.empty()) return 0;
  nlohmann::ordered_json stats = {{"frames", due.size()}, {"cpu", name(on)}, {"threads", pool.threads()}};
  report_skips(work, frames.texels_unneeded(), frames.file_counts().repeated, stats);
  AtomicFile file(stats_);
  file.write(stats.dump(2) + "\n");
  file.commit();
  return 0;
}

}  // namespace

std::unique_ptr<Command> make_render_command(CLI::App& program) {
  return std::make_unique<RenderCommand>(program);
}

}  // namespace cupola
