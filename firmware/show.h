// A show: what is played on a rig, cue after cue, read from one TOML file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "firmware/control_settings.h"
#include "firmware/machine_settings.h"
#include "firmware/rig_devices.h"
#include "firmware/sound_settings.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/settings/settings_errors.h"
#include "pipeline/source/face_source.h"
#include "pipeline/source/file_source.h"
#include "pipeline/warp/frame_warp.h"

namespace cupola {

enum class CueSource : std::uint8_t { kStills, kSequence, kAtlas, kVideo, kGenerated, kTestPattern, kLive };

inline constexpr const char* kOwnSound = "own";  // the sound of the cue's own video

struct Cue {
  std::string name;
  CueSource source = CueSource::kGenerated;
  std::string file;                          // kStills, kSequence, kAtlas, kVideo: a path or pattern
  std::vector<std::filesystem::path> files;  // kStills: one a view, instead of `file`
  AtlasLayout layout;                        // kAtlas; kVideo, unless every view has a file
  bool finished = false;                     // the pictures are the dome's, as large as the frame: no warp
  std::string world;                         // kGenerated, kTestPattern
  Size face_size{1024, 1024};
  double rate = 60.0;  // frames a second; 0: the file's own
  std::optional<double> duration_s;
  SequencePart part;  // file numbers, or frames of a generated world
  bool loop = false;
  std::optional<Method> compare;    // the left half of the frame is made by this method
  std::optional<std::size_t> then;  // the next cue's place; none: the show stops
  double fade_s = 0.0;              // mixed with what was shown before for so long; 0: a cut
  bool wait = false;                // first the last picture stands until the operator says go
  std::string sound;                // a file, or kOwnSound; empty: none
};

struct Show {
  std::string name;  // for the files it is rendered to
  std::filesystem::path file;
  Rig rig;
  RigDevices devices;  // of the same file
  ControlSettings control;
  MachineSettings machine;
  SoundSettings sound;
  std::vector<Cue> cues;  // at least one
  bool sounds() const;    // some cue has a sound
  bool live() const;      // some cue is live
};

// `file` may be the name of a show in config/shows. Overrides that begin with "rig." go to the rig's file,
// the others to the show's; `rig`, unless empty, replaces the show's own. Throws InputError; with `errors`
// all of show and rig are gathered there instead, but for a show file that is no TOML: what is wrong is then
// left empty, a rig without views, a cue with nothing but its name.
Show load_show(const std::filesystem::path& file, std::span<const std::string> overrides,
               const std::filesystem::path& rig = {}, SettingsErrors* errors = nullptr);

// The rig file of that path, or of that name in config/rigs.
Rig load_named_rig(const std::filesystem::path& file, std::span<const std::string> overrides,
                   SettingsErrors* errors = nullptr);

// Opens what the cue shows; throws InputError. `pool` is borrowed for the source's life.
std::unique_ptr<FaceSource> open_source(const Cue& cue, const Rig& rig, WorkerPool& pool);

// Gives the rig's views the sizes of the cue's faces; throws InputError where the rig demands others. Faces
// of 16 bits get the precise table: eight-bit weights would waste their depth.
void fit_faces(Rig& rig, const Cue& cue, const FaceSource& source);

// The cue's, or its file's; 60 where that says nothing.
double rate_of(const Cue& cue, const FaceSource& source);

// Everything that a cue says, as a text to compare with another one's.
std::string all_of(const Cue& cue);

// "3x2" and the names of its cells, row by row.
AtlasLayout parse_layout(const std::string& columns_and_rows, std::vector<std::string> faces);

}  // namespace cupola
