// Reading show files, and opening what they name.
// SPDX-License-Identifier: MIT
#include "firmware/show.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cstdio>

#include "pipeline/frame/error.h"
#include "pipeline/optics/config_path.h"
#include "pipeline/settings/settings.h"
#include "pipeline/settings/settings_errors.h"
#include "pipeline/source/generated_source.h"
#include "pipeline/source/numbered_files.h"
#include "pipeline/source/world.h"

namespace cupola {
namespace {

constexpr int kLargestFace = 16384;  // texels
constexpr std::int64_t kMostPadding = 4096;
constexpr std::int64_t kMostFrames = 1'000'000'000;
constexpr std::array<std::string_view, 7> kSources = {"stills",    "sequence",     "atlas", "video",
                                                      "generated", "test-pattern", "live"};
constexpr std::array<std::string_view, 3> kLaterSources = {"scene", "composite", "multiprojection"};
constexpr std::array<std::string_view, 2> kTransitions = {"cut", "fade"};

std::filesystem::path found(const std::filesystem::path& file, const std::filesystem::path& directory,
                            std::string_view room) {
  std::error_code ignored;
  const std::filesystem::path beside = (directory / file).lexically_normal();
  if (std::filesystem::is_regular_file(beside, ignored)) return beside;
  const std::filesystem::path named = find_config(file, directory, room);
  return named.empty() ? beside : named.lexically_normal();  // whoever opens it says what is wrong
}

// FFmpeg's order of a cube's faces, and the paper's four.
std::vector<std::string> usual_faces(int cells) {
  if (cells == 6) return {"right", "left", "top", "bottom", "front", "back"};
  if (cells == 4) return {"front", "left", "right", "top"};
  return {};
}

// Where nobody knows whether there should be one.
void read_any_layout(SettingsTable& table) {
  try {
    parse_layout(table.text("layout", "1x1"), {});
  } catch (const InputError& error) {
    table.refuse("layout", error.what());
  }
  if (table.has("faces")) table.texts("faces", 1, 64);
  table.integer("padding", 0, kMostPadding, 0);
}

std::optional<Size> read_face_size(SettingsTable& table) {
  if (!table.has("face_size")) return std::nullopt;
  const std::vector<double> size = table.numbers("face_size", 2, 2);
  for (const double side : size) {
    if (side < 1 || side > kLargestFace || side != static_cast<int>(side)) {
      table.refuse("face_size", fmt::format("expected whole numbers from 1 to {}", kLargestFace));
    }
  }
  if (table.refused("face_size")) return std::nullopt;
  return Size{static_cast<int>(size[0]), static_cast<int>(size[1])};
}

void read_layout(SettingsTable& table, Cue& cue) {
  const bool video = cue.source == CueSource::kVideo;
  if (cue.source != CueSource::kAtlas && !video) return;
  if (video && (table.refused("file") || table.refused("finished"))) return read_any_layout(table);
  if (video && (cue.finished || has_view(cue.file))) {
    if (table.has("layout")) {
      table.refuse("layout", cue.finished ? "expected none where the pictures are finished"
                                          : "expected none where every view has a file");
      table.may_have({"layout", "faces", "padding"});
    }
    return;
  }
  if (video && !table.has("layout")) {
    table.refuse("file", "expected {view} in it, or a layout, or finished = true");
    table.may_have({"faces", "padding"});
    return;
  }
  const std::string layout = table.text("layout");
  std::vector<std::string> faces;
  if (!video || table.has("faces")) faces = table.texts("faces", 1, 64);
  const bool usual = faces.empty();
  if (!table.refused("layout") && !table.refused("faces")) {
    try {
      cue.layout = parse_layout(layout, std::move(faces));
    } catch (const InputError& error) {
      table.refuse("layout", error.what());
    }
  }
  if (usual) cue.layout.faces = usual_faces(cue.layout.columns * cue.layout.rows);
  if (cue.layout.faces.empty() && !table.refused("layout"))
    table.refuse("faces", "missing; expected the faces of the layout's cells");
  cue.layout.padding = static_cast<int>(table.integer("padding", 0, kMostPadding, 0));
}

// Where nobody knows what the source is: what means the same with all of them.
void read_of_any_source(SettingsTable& table) {
  table.text("file", "");
  table.choice("world", world_names(), 0);
  read_face_size(table);
  table.flag("finished", false);
  read_any_layout(table);
  table.choice("compare", kMethodNames, 0);
  table.number("rate", 0.01, 1000.0, 60.0);
  table.number("duration_s", 0.001, 1e7, 1.0);
  table.integer("in", 0, kMostFrames, 0);
  table.integer("out", 0, kMostFrames, 0);
  table.flag("loop", false);
  const bool fades = table.choice("transition", kTransitions, 0) == 1;
  if (fades || (table.refused("transition") && table.has("fade_s"))) table.number("fade_s", 0.001, 3600.0);
}

void read_cue_sound(SettingsTable& table, const std::filesystem::path& directory, Cue& cue) {
  if (!table.has("sound")) return;
  const std::string sound = table.text("sound");
  if (sound.empty()) table.refuse("sound", "expected a file, or own");
  if (sound != kOwnSound) {
    cue.sound = (directory / sound).string();
    return;
  }
  if (cue.source != CueSource::kVideo)
    table.refuse("sound", "expected a file: only a video has a sound of its own");
  if (cue.rate > 0.0)
    table.refuse("sound", "expected a file beside a rate: a video's own sound plays at its own");
  cue.sound = sound;
}

Cue read_cue(SettingsTable& table, const std::filesystem::path& directory) {
  Cue cue;
  cue.name = table.text("name");
  if (cue.name.empty()) table.refuse("name", "expected a name");
  const std::string source = table.has("source") ? table.text("source") : "";
  if (std::find(kLaterSources.begin(), kLaterSources.end(), source) != kLaterSources.end()) {
    table.refuse("source", fmt::format("{} is not part of this version", source));
  }
  cue.source = static_cast<CueSource>(table.choice("source", kSources));
  if (table.refused("source")) {
    read_of_any_source(table);
    return cue;
  }
  const bool from_files = cue.source <= CueSource::kVideo;
  if (from_files) {
    cue.file = (directory / table.text("file")).string();
  } else if (cue.source != CueSource::kLive) {
    const auto names = world_names();
    cue.world = names[table.choice("world", names)];
    cue.face_size = read_face_size(table).value_or(cue.face_size);
  }
  if (from_files && cue.source != CueSource::kAtlas) cue.finished = table.flag("finished", false);
  read_layout(table, cue);
  // A video without a rate of its own plays at that of its file.
  const bool own_rate = cue.source == CueSource::kVideo && !table.has("rate");
  if (cue.source != CueSource::kLive) {
    const double rate = table.number("rate", 0.01, 1000.0, 60.0);
    cue.rate = own_rate ? 0.0 : rate;
  }
  if (table.has("duration_s")) cue.duration_s = table.number("duration_s", 0.001, 1e7);
  if (cue.source != CueSource::kStills && cue.source != CueSource::kLive) {
    if (table.has("in")) cue.part.in = table.integer("in", 0, kMostFrames);
    const std::int64_t in = table.refused("in") ? 0 : cue.part.in.value_or(0);
    if (table.has("out")) cue.part.out = table.integer("out", in, kMostFrames);
    cue.loop = table.flag("loop", false);
  }
  read_cue_sound(table, directory, cue);
  if (table.has("compare") && (cue.finished || cue.source == CueSource::kLive)) {
    table.refuse("compare", fmt::format("expected none where {}",
                                        cue.finished ? "the pictures are finished" : "the source is live"));
    table.may_have({"compare"});
  }
  if (table.has("compare")) cue.compare = static_cast<Method>(table.choice("compare", kMethodNames));
  if (table.choice("transition", kTransitions, 0) == 1) {
    cue.fade_s = table.number("fade_s", 0.001, 3600.0);
    const bool known = !table.refused("fade_s") && !table.refused("duration_s");
    if (known && cue.duration_s && cue.fade_s > *cue.duration_s) {
      table.refuse("fade_s", fmt::format("expected at most the cue's duration_s, {}", *cue.duration_s));
    }
  }
  if (table.refused("transition") && table.has("fade_s")) table.number("fade_s", 0.001, 3600.0);
  return cue;
}

// The place of the cue that follows cue `index`.
std::optional<std::size_t> read_then(SettingsTable& table, std::size_t index, std::span<const Cue> cues,
                                     bool all_named) {
  const std::string then = table.text("then", "next");
  if (then == "stop") return std::nullopt;
  if (then == "next" || then == "wait")
    return index + 1 < cues.size() ? std::optional(index + 1) : std::nullopt;
  for (std::size_t other = 0; other < cues.size(); ++other) {
    if (cues[other].name == then) return other;
  }
  if (!all_named) return std::nullopt;
  std::vector<std::string_view> names = {"next", "wait", "stop"};
  for (const Cue& cue : cues) names.push_back(cue.name);
  const std::string_view nearest = nearest_name(then, names);
  table.refuse("then", fmt::format("expected next, wait, stop or the name of a cue, not \"{}\"{}", then,
                                   nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
  return std::nullopt;
}

// Paths are relative to the show.
ControlSettings read_control(SettingsTable table, const std::filesystem::path& directory) {
  ControlSettings control;
  if (table.has("token_file")) control.token_file = directory / table.text("token_file");
  for (const auto& [key, listened] : {std::pair("http", &control.http), std::pair("osc", &control.osc)}) {
    if (!table.has(key)) continue;
    try {
      *listened = parse_control_address(table.text(key));
    } catch (const InputError& error) {
      table.refuse(key, error.what());
      continue;
    }
    if (!(*listened)->loopback && !table.refused("token_file") && control.token_file.empty()) {
      table.refuse(key, "expected a token_file beside an address that others can reach");
    }
  }
  table.finish();
  return control;
}

}  // namespace

AtlasLayout parse_layout(const std::string& columns_and_rows, std::vector<std::string> faces) {
  AtlasLayout layout;
  char rest = 0;
  if (std::sscanf(columns_and_rows.c_str(), "%3dx%3d%c", &layout.columns, &layout.rows, &rest) != 2 ||
      layout.columns < 1 || layout.rows < 1) {
    throw InputError(fmt::format("expected columns x rows, like 3x2, not {}", columns_and_rows));
  }
  if (faces.size() > static_cast<std::size_t>(layout.columns * layout.rows)) {
    throw InputError(fmt::format("{} has {} cells; {} faces are too many", columns_and_rows,
                                 layout.columns * layout.rows, faces.size()));
  }
  layout.faces = std::move(faces);
  return layout;
}

Rig load_named_rig(const std::filesystem::path& file, std::span<const std::string> overrides,
                   SettingsErrors* errors) {
  return load_rig(found(file, {}, "rigs"), overrides, errors);
}

namespace {

// What is wrong with the cues together; those that are wrong themselves stay empty but for their names.
std::vector<Cue> read_cues(std::vector<SettingsTable>& tables, const std::filesystem::path& directory) {
  std::vector<Cue> cues;
  bool all_named = true;
  for (SettingsTable& table : tables) {
    cues.push_back(read_cue(table, directory));
    all_named = all_named && !table.refused("name");
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    SettingsTable& table = tables[i];
    for (std::size_t j = 0; j < i && !table.refused("name"); ++j) {
      if (cues[j].name == cues[i].name) {
        table.refuse("name", fmt::format("expected a name of its own; \"{}\" is taken", cues[i].name));
      }
    }
    cues[i].then = read_then(table, i, cues, all_named);
    cues[i].wait = table.text("then", "") == "wait";
    table.finish();
  }
  for (std::size_t i = 0; i < tables.size(); ++i) {
    if (!tables[i].refused("")) continue;
    Cue empty;
    empty.name = cues[i].name;
    cues[i] = empty;
  }
  return cues;
}

}  // namespace

Show load_show(const std::filesystem::path& file, std::span<const std::string> overrides,
               const std::filesystem::path& rig, SettingsErrors* errors) {
  const std::filesystem::path path = found(file, {}, "shows");
  std::vector<std::string> for_rig;
  std::vector<std::string> for_show;
  for (const std::string& line : overrides) {
    if (line.starts_with("rig.")) {
      for_rig.push_back(line.substr(4));
    } else {
      for_show.push_back(line);
    }
  }
  Show show;
  show.name = path.stem().string();
  show.file = path;
  SettingsTable root = load_settings(path, for_show, errors);
  const std::filesystem::path directory = path.parent_path();
  const std::string own = rig.empty() ? root.text("rig") : root.text("rig", "");
  if (!root.refused("rig")) {
    root.attempt("rig", [&] {
      const std::size_t before = errors ? errors->count() : 0;
      Rig read = rig.empty() ? load_rig(found(own, directory, "rigs"), for_rig, errors)
                             : load_named_rig(rig, for_rig, errors);
      show.devices = load_rig_devices(read.file, for_rig, errors);
      if (!errors || errors->count() == before) show.rig = std::move(read);
    });
  }
  show.control = read_control(root.table("control"), directory);
  show.machine = read_machine(root.table("machine"));
  show.sound = read_sound(root.table("sound"));
  std::vector<SettingsTable> tables = root.tables("cue");
  const auto expect_cues = [&] {
    if (tables.empty()) root.refuse("cue", "missing; expected at least one [[cue]]");
  };
  if (errors) expect_cues();
  root.finish();  // a misspelt [[cue]] first
  expect_cues();
  show.cues = read_cues(tables, directory);
  return show;
}

bool Show::sounds() const {
  return std::ranges::any_of(cues, [](const Cue& cue) { return !cue.sound.empty(); });
}

bool Show::live() const {
  return std::ranges::any_of(cues, [](const Cue& cue) { return cue.source == CueSource::kLive; });
}

void fit_faces(Rig& rig, const Cue& cue, const FaceSource& source) {
  const std::vector<Size> sizes = source.face_sizes();
  if (cue.finished) {
    if (sizes[0] == rig.frame.size) return;
    throw InputError(fmt::format("{}: {} x {} pixels; expected {} x {}, as the frame of {} has them",
                                 cue.file, sizes[0].width, sizes[0].height, rig.frame.size.width,
                                 rig.frame.size.height, rig.file.string()));
  }
  for (std::size_t i = 0; i < std::min(cue.files.size(), rig.views.size()); ++i) {
    const View& view = rig.views[i];
    if (view.size == Size{} || view.size == sizes[i]) continue;
    throw InputError(fmt::format("{}: {} x {} pixels; expected {} x {}, as {} has them for view {}",
                                 cue.files[i].string(), sizes[i].width, sizes[i].height, view.size.width,
                                 view.size.height, rig.file.string(), view.name));
  }
  set_view_sizes(rig, sizes);
  if (source.format() == PixelFormat::kRgbPlanar16) rig.filter.table = TableForm::kPrecise;
}

// The structured binding fails when a member is added, so that it is not forgotten here.
std::string all_of(const Cue& cue) {
  const auto& [name, source, file, files, layout, finished, world, face_size, rate, duration_s, part, loop,
               compare, then, fade_s, wait, sound] = cue;
  std::string text = fmt::format("{}|{}|{}|{}x{}+{} {}|{}|{}|{}x{}|{}|{}|{} {}|{}|{}|{}|{}|{}", name,
                                 static_cast<int>(source), file, layout.columns, layout.rows, layout.padding,
                                 fmt::join(layout.faces, ","), finished, world, face_size.width,
                                 face_size.height, rate, duration_s.value_or(-1.0), part.in.value_or(-1),
                                 part.out.value_or(-1), loop, compare ? static_cast<int>(*compare) : -1,
                                 then ? static_cast<int>(*then) : -1, fade_s, wait);
  for (const std::filesystem::path& one : files) text += "|" + one.string();
  static_cast<void>(sound);  // no picture depends on it
  return text + "\n";
}

double rate_of(const Cue& cue, const FaceSource& source) {
  if (cue.rate > 0.0) return cue.rate;
  const auto* files = dynamic_cast<const FileSource*>(&source);
  return files && files->rate() > 0.0 ? files->rate() : 60.0;
}

std::unique_ptr<FaceSource> open_source(const Cue& cue, const Rig& rig, WorkerPool& pool) {
  std::vector<std::string> views;
  for (const View& view : rig.views) views.push_back(view.name);
  if (cue.finished) views = {"dome"};
  switch (cue.source) {
    case CueSource::kStills:
      return open_stills(cue.files.empty() ? files_of_views(cue.file, views) : cue.files, &pool);
    case CueSource::kSequence:
      if (has_number(cue.file) || std::filesystem::is_directory(cue.file)) {
        return open_sequence(cue.file, views, cue.part, &pool);
      }
      return open_videos(files_of_views(cue.file, views), &pool);
    case CueSource::kAtlas:
      return open_atlas(cue.file, cue.layout, views, cue.part);
    case CueSource::kVideo:
      if (cue.layout.faces.empty()) return open_video_views(files_of_views(cue.file, views));
      return open_video_atlas(cue.file, cue.layout, views);
    case CueSource::kGenerated:
    case CueSource::kTestPattern:
      return std::make_unique<GeneratedSource>(rig.views, rig.world_from_lens, make_world(cue.world),
                                               cue.rate, pool, cue.face_size);
    case CueSource::kLive:
      break;  // LiveFrames takes its faces from the cameras
  }
  return nullptr;
}

}  // namespace cupola
