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
#include "pipeline/source/generated_source.h"
#include "pipeline/source/numbered_files.h"
#include "pipeline/source/world.h"

namespace cupola {
namespace {

constexpr int kLargestFace = 16384;  // texels
constexpr std::array<std::string_view, 6> kSources = {"stills",    "sequence",     "atlas",
                                                      "generated", "test-pattern", "live"};
constexpr std::array<std::string_view, 5> kLaterSources = {"video", "scene", "composite", "multiprojection",
                                                           "fade"};

std::filesystem::path found(const std::filesystem::path& file, const std::filesystem::path& directory,
                            std::string_view room) {
  std::error_code ignored;
  const std::filesystem::path beside = (directory / file).lexically_normal();
  if (std::filesystem::is_regular_file(beside, ignored)) return beside;
  const std::filesystem::path named = find_config(file, directory, room);
  return named.empty() ? beside : named.lexically_normal();  // whoever opens it says what is wrong
}

Cue read_cue(SettingsTable& table, const std::filesystem::path& directory) {
  Cue cue;
  cue.name = table.text("name");
  if (cue.name.empty()) table.refuse("name", "expected a name");
  const std::string source = table.text("source");
  if (std::find(kLaterSources.begin(), kLaterSources.end(), source) != kLaterSources.end()) {
    table.refuse("source", fmt::format("{} is not part of this version", source));
  }
  cue.source = static_cast<CueSource>(table.choice("source", kSources));
  const bool from_files = cue.source <= CueSource::kAtlas;
  if (from_files) {
    cue.file = (directory / table.text("file")).string();
  } else if (cue.source != CueSource::kLive) {
    const auto names = world_names();
    cue.world = names[table.choice("world", names)];
    if (table.has("face_size")) {
      const std::vector<double> size = table.numbers("face_size", 2, 2);
      for (const double side : size) {
        if (side < 1 || side > kLargestFace || side != static_cast<int>(side)) {
          table.refuse("face_size", fmt::format("expected whole numbers from 1 to {}", kLargestFace));
        }
      }
      cue.face_size = {static_cast<int>(size[0]), static_cast<int>(size[1])};
    }
  }
  if (cue.source == CueSource::kAtlas) {
    try {
      cue.layout = parse_layout(table.text("layout"), table.texts("faces", 1, 64));
    } catch (const InputError& error) {
      table.refuse("layout", error.what());
    }
  }
  if (cue.source != CueSource::kLive) cue.rate = table.number("rate", 0.01, 1000.0, 60.0);
  if (table.has("duration_s")) cue.duration_s = table.number("duration_s", 0.001, 1e7);
  if (cue.source != CueSource::kStills && cue.source != CueSource::kLive) {
    constexpr std::int64_t kMost = 1'000'000'000;
    if (table.has("in")) cue.part.in = table.integer("in", 0, kMost);
    if (table.has("out")) cue.part.out = table.integer("out", cue.part.in.value_or(0), kMost);
    cue.loop = table.flag("loop", false);
  }
  if (table.has("compare")) cue.compare = static_cast<Method>(table.choice("compare", kMethodNames));
  if (table.text("transition", "cut") != "cut") {
    table.refuse("transition",
                 table.text("transition") == "fade" ? "fade is not part of this version" : "expected cut");
  }
  return cue;
}

// The place of the cue that follows cue `index`.
std::optional<std::size_t> read_then(SettingsTable& table, std::size_t index, std::span<const Cue> cues) {
  const std::string then = table.text("then", "next");
  if (then == "wait") table.refuse("then", "wait is not part of this version");
  if (then == "stop") return std::nullopt;
  if (then == "next") return index + 1 < cues.size() ? std::optional(index + 1) : std::nullopt;
  for (std::size_t other = 0; other < cues.size(); ++other) {
    if (cues[other].name == then) return other;
  }
  std::vector<std::string_view> names = {"next", "stop"};
  for (const Cue& cue : cues) names.push_back(cue.name);
  const std::string_view nearest = nearest_name(then, names);
  table.refuse("then", fmt::format("expected next, stop or the name of a cue, not \"{}\"{}", then,
                                   nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest)));
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

Rig load_named_rig(const std::filesystem::path& file, std::span<const std::string> overrides) {
  return load_rig(found(file, {}, "rigs"), overrides);
}

Show load_show(const std::filesystem::path& file, std::span<const std::string> overrides,
               const std::filesystem::path& rig, std::vector<std::string>* errors) {
  const auto attempt = [&](auto&& read) {
    try {
      read();
    } catch (const InputError& error) {
      if (!errors) throw;
      errors->emplace_back(error.what());
    }
  };
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
  attempt([&] {
    SettingsTable root = load_settings(path, for_show);
    const std::filesystem::path directory = path.parent_path();
    std::vector<SettingsTable> tables;
    attempt([&] {
      const std::string own = rig.empty() ? root.text("rig") : root.text("rig", "");
      show.rig =
          rig.empty() ? load_rig(found(own, directory, "rigs"), for_rig) : load_named_rig(rig, for_rig);
      show.devices = load_rig_devices(show.rig.file, for_rig);
    });
    attempt([&] { tables = root.tables("cue"); });
    attempt([&] { root.finish(); });
    attempt([&] {
      if (tables.empty()) root.refuse("cue", "missing; expected at least one [[cue]]");
    });
    std::vector<bool> readable(tables.size());
    show.cues.resize(tables.size());
    for (std::size_t i = 0; i < tables.size(); ++i) {
      attempt([&] {
        show.cues[i].name = tables[i].text("name");
        show.cues[i] = read_cue(tables[i], directory);
        readable[i] = true;
      });
    }
    for (std::size_t i = 0; i < tables.size(); ++i) {
      if (!readable[i]) continue;
      attempt([&] {
        for (std::size_t j = 0; j < i; ++j) {
          if (show.cues[j].name == show.cues[i].name) {
            tables[i].refuse("name",
                             fmt::format("expected a name of its own; \"{}\" is taken", show.cues[i].name));
          }
        }
        if (show.cues[i].source == CueSource::kLive && show.cues.size() > 1) {
          tables[i].refuse("source", "expected live in a show of one cue");
        }
        show.cues[i].then = read_then(tables[i], i, show.cues);
        tables[i].finish();
      });
    }
  });
  return show;
}

void fit_faces(Rig& rig, const Cue& cue, const FaceSource& source) {
  const std::vector<Size> sizes = source.face_sizes();
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

std::unique_ptr<FaceSource> open_source(const Cue& cue, const Rig& rig, WorkerPool& pool) {
  std::vector<std::string> views;
  for (const View& view : rig.views) views.push_back(view.name);
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
