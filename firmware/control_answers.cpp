// Everything here is made on the asking thread, from a copy of the status.
// SPDX-License-Identifier: MIT
#include "firmware/control_answers.h"

#include <fmt/format.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <nlohmann/json.hpp>

#include "pipeline/frame/error.h"

#include "firmware/file_report.h"
#include "firmware/sound_text.h"

namespace cupola {
namespace {

using Json = nlohmann::ordered_json;

constexpr std::array<PlayerState, 5> kStates = {PlayerState::kStarting, PlayerState::kPlaying,
                                                PlayerState::kPaused, PlayerState::kWaiting,
                                                PlayerState::kOver};
constexpr std::array<const char*, 3> kShown = {"in step", "late", "slate"};

double seconds(std::chrono::nanoseconds time) {
  return static_cast<double>(time.count()) / 1e9;
}
double milliseconds(std::chrono::nanoseconds time) {
  return static_cast<double>(time.count()) / 1e6;
}

// Texts may hold bytes that are no UTF-8 (file names): those become question marks.
std::string dump(const Json& json) {
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

// Zone and degrees, of what the kernel lets us read.
std::vector<std::pair<std::string, double>> temperatures() {
  std::vector<std::pair<std::string, double>> zones;
  std::error_code ignored;
  for (const auto& zone : std::filesystem::directory_iterator("/sys/class/thermal", ignored)) {
    const std::string name = zone.path().filename();
    std::ifstream in(zone.path() / "temp");
    double millidegrees = 0.0;
    if (name.starts_with("thermal_zone") && in >> millidegrees) zones.emplace_back(name, 1e-3 * millidegrees);
  }
  return zones;
}

class Metrics {
 public:
  void family(std::string_view name, std::string_view type, std::string_view help) {
    text_ += fmt::format("# HELP cupola_{0} {2}\n# TYPE cupola_{0} {1}\n", name, type, help);
  }
  template <class Value>
  void sample(std::string_view name, Value value, std::string_view labels = "") {
    text_ += fmt::format("cupola_{}{}{}{} {}\n", name, labels.empty() ? "" : "{", labels,
                         labels.empty() ? "" : "}", value);
  }
  template <class Value>
  void one(std::string_view name, std::string_view type, std::string_view help, Value value) {
    family(name, type, help);
    sample(name, value);
  }
  void histogram(std::string_view name, std::string_view help, const StageTimes& times) {
    family(name, "histogram", help);
    std::int64_t count = 0;
    for (std::size_t i = 0; i < times.kUpTo.size(); ++i) {
      count += times.within[i];
      sample(fmt::format("{}_bucket", name), count, fmt::format("le=\"{:g}\"", seconds(times.kUpTo[i])));
    }
    count += times.beyond;
    sample(fmt::format("{}_bucket", name), count, "le=\"+Inf\"");
    sample(fmt::format("{}_sum", name), seconds(times.sum));
    sample(fmt::format("{}_count", name), count);
  }
  const std::string& text() const { return text_; }

 private:
  std::string text_;
};

std::string label(std::string_view name, std::string_view value) {
  std::string text = fmt::format("{}=\"", name);
  for (const char c : value) {
    if (c == '\\' || c == '"') text += '\\';
    text += c == '\n' ? ' ' : c;
  }
  return text + '"';
}

void add_sound(Metrics& metrics, const PlayerStatus& status) {
  const SoundReport& sound = status.sound;
  if (!sound.wanted) return;
  metrics.one("sound_working", "gauge", "Whether the sound device is there.", sound.working ? 1 : 0);
  metrics.one("sound_drift_seconds", "gauge", "Of the sound heard against the show's time; above 0: early.",
              seconds(sound.drift));
  metrics.one("sound_device_ppm", "gauge", "By which the device's clock is faster than the machine's.",
              sound.device_ppm);
  metrics.one("sound_underruns_total", "counter", "Times that the device had nothing to play.",
              sound.underruns);
  metrics.one("sound_losses_total", "counter", "Times that the device went away.", sound.losses);
  metrics.one("sound_frames_missing_total", "counter", "Frames that were not decoded in time.",
              sound.missing);
  metrics.one("sound_packets_damaged_total", "counter", "Packets that could not be decoded.", sound.damaged);
  metrics.one("sound_volume_percent", "gauge", "As the operator has it.", status.volume);
}

void add_osc(Metrics& metrics, const OscReport& osc) {
  if (!osc.wanted) return;
  metrics.family("osc_messages_total", "counter", "That came over OSC, by what became of them.");
  metrics.sample("osc_messages_total", osc.taken, "is=\"taken\"");
  metrics.sample("osc_messages_total", osc.released, "is=\"released\"");
  metrics.sample("osc_messages_total", osc.refused, "is=\"refused\"");
  metrics.sample("osc_messages_total", osc.denied, "is=\"denied\"");
  metrics.sample("osc_messages_total", osc.crowded, "is=\"crowded\"");
}

void add_cameras(Metrics& metrics, const ShowReport& show, const ShowFacts& facts) {
  if (show.camera_count == 0) return;
  const auto each = [&](std::string_view name, std::string_view type, std::string_view help, auto value) {
    metrics.family(name, type, help);
    for (std::size_t c = 0; c < std::min(show.camera_count, facts.cameras.size()); ++c) {
      metrics.sample(name, value(show.cameras[c]), label("view", facts.cameras[c]));
    }
  };
  each("camera_in_step", "gauge", "Whether the camera's picture belongs to the set shown.",
       [](const CameraReport& c) { return c.shown == CameraReport::Shown::kInStep ? 1 : 0; });
  each("camera_frames_total", "counter", "Frames handed on.", [](const CameraReport& c) { return c.frames; });
  each("camera_frames_dropped_total", "counter", "Frames that the device dropped.",
       [](const CameraReport& c) { return c.dropped; });
  each("camera_frames_damaged_total", "counter", "Frames with errors.",
       [](const CameraReport& c) { return c.damaged; });
  each("camera_losses_total", "counter", "Times that frames ceased to flow.",
       [](const CameraReport& c) { return c.losses; });
  each("camera_offset_seconds", "gauge", "The camera's clock against the first one's.",
       [](const CameraReport& c) { return seconds(c.offset); });
  each("camera_drift_ppm", "gauge", "What the offset gains.",
       [](const CameraReport& c) { return c.drift_ppm; });
  if (!show.exposure) return;
  metrics.one("camera_exposure_seconds", "gauge", "What all cameras are told.",
              1e-6 * show.exposure->told.us);
  metrics.one("camera_gain", "gauge", "What all cameras are told.", show.exposure->told.gain);
}

}  // namespace

ShowFacts facts_of(const Show& show, const std::string& display) {
  ShowFacts facts;
  facts.show = show.name;
  for (const Cue& cue : show.cues) {
    facts.cues.push_back(cue.name);
    facts.finished.push_back(cue.finished);
    facts.live.push_back(cue.source == CueSource::kLive);
  }
  for (const View& view : show.rig.views) facts.views.push_back(view.name);
  if (show.live()) {
    for (const RigCamera& camera : show.devices.cameras) facts.cameras.push_back(camera.view);
  }
  facts.display = display;
  return facts;
}

std::vector<std::string> views_of(const ShowFacts& facts, const PlayerStatus& status) {
  const std::size_t cue = status.show.cue;
  const bool none = cue < facts.finished.size() && facts.finished[cue];
  return none ? std::vector<std::string>() : facts.views;
}

std::string status_json(const PlayerStatus& status, const ShowFacts& facts,
                        const std::string& reload_trouble) {
  const ShowReport& show = status.show;
  const LoopCounts& counts = status.counts;
  Json json = {{"state", name_of(status.state)},
               {"blackout", status.black},
               {"light", status.light},
               {"test_pattern", status.pattern ? test_patterns()[status.pattern - 1] : ""},
               {"show", facts.show},
               {"live", show.cue < facts.live.size() && facts.live[show.cue]},
               {"cue", show.cue + 1},
               {"cue_name", show.cue < facts.cues.size() ? facts.cues[show.cue] : ""},
               {"cues", facts.cues.size()},
               {"position_s", seconds(show.position)},
               {"duration_s", show.duration ? Json(seconds(*show.duration)) : Json()},
               {"running_s", seconds(status.running)},
               {"display", facts.display},
               {"reload_trouble", reload_trouble},
               {"test_patterns", test_patterns()},
               {"views", views_of(facts, status)},
               {"display_away", status.display_away},
               {"rate_hz", status.period.count() > 0 ? 1.0 / seconds(status.period) : 0.0},
               {"trouble", status.failing ? show.trouble.data() : ""},
               {"frames",
                {{"presented", counts.frames_presented},
                 {"unchanged", counts.frames_unchanged},
                 {"nv12", counts.frames_nv12},
                 {"late", counts.frames_late},
                 {"dropped", counts.frames_dropped},
                 {"dropped_by",
                  {{"faces", counts.dropped_by_faces},
                   {"warp", counts.dropped_by_warp},
                   {"display", counts.dropped_by_display}}},
                 {"failed", counts.frames_failed},
                 {"unshown", counts.frames_unshown},
                 {"blackout", counts.blackout_frames}}},
               {"files", describe(show.files)},
               {"queue", {{"frames", show.queue.frames}, {"most", show.queue.most}}},
               {"faces_ms", milliseconds(counts.faces.last)},
               {"warp_ms", milliseconds(counts.warp.last)},
               {"preview_bytes_copied", counts.preview_bytes_copied},
               {"temperatures_c", Json::object()},
               {"cameras", Json::array()}};
  for (const auto& [zone, degrees] : temperatures()) json["temperatures_c"][zone] = degrees;
  for (std::size_t c = 0; c < std::min(show.camera_count, facts.cameras.size()); ++c) {
    const CameraReport& camera = show.cameras[c];
    json["cameras"].push_back({{"view", facts.cameras[c]},
                               {"shows", kShown[static_cast<std::size_t>(camera.shown)]},
                               {"frames", camera.frames},
                               {"dropped", camera.dropped},
                               {"damaged", camera.damaged},
                               {"losses", camera.losses},
                               {"offset_ms", milliseconds(camera.offset)},
                               {"drift_ppm", camera.drift_ppm}});
    if (!camera.colour) continue;
    json["cameras"].back()["gains"] = camera.colour->gain;
    json["cameras"].back()["offsets"] = camera.colour->offset;
  }
  if (show.exposure) {
    json["exposure"] = {{"us", show.exposure->told.us},
                        {"gain", show.exposure->told.gain},
                        {"brightness", show.exposure->brightness}};
  }
  if (status.sound.wanted) {
    json["sound"] = describe(status.sound);
    json["sound"]["volume"] = status.volume;
  }
  if (const OscReport& osc = status.osc; osc.wanted) {
    json["osc"] = {{"taken", osc.taken},
                   {"released", osc.released},
                   {"refused", osc.refused},
                   {"denied", osc.denied},
                   {"crowded", osc.crowded}};
  }
  return dump(json);
}

std::string cues_json(const PlayerStatus& status, const ShowFacts& facts) {
  Json cues = Json::array();
  for (std::size_t i = 0; i < facts.cues.size(); ++i) {
    cues.push_back({{"number", i + 1}, {"name", facts.cues[i]}, {"current", i == status.show.cue}});
  }
  return dump({{"show", facts.show}, {"cues", cues}});
}

std::string log_json(const std::vector<EventLog::Line>& lines) {
  Json json = Json::array();
  for (const EventLog::Line& line : lines) {
    json.push_back({{"number", line.number},
                    {"time", utc_text(line.at)},
                    {"severity", name_of(line.severity)},
                    {"topic", name_of(line.topic)},
                    {"text", line.text}});
  }
  return dump({{"lines", json}});
}

std::string error_json(std::string_view error) {
  return dump({{"error", error}});
}

std::string metrics_text(const PlayerStatus& status, const ShowFacts& facts) {
  const LoopCounts& counts = status.counts;
  Metrics metrics;
  metrics.one("running_seconds", "gauge", "Since the first flip.", seconds(status.running));
  metrics.family("state", "gauge", "1 for the state that the player is in.");
  for (const PlayerState state : kStates) {
    metrics.sample("state", status.state == state ? 1 : 0, label("state", name_of(state)));
  }
  metrics.one("blackout", "gauge", "Whether the picture is black by the operator's wish.",
              status.black ? 1 : 0);
  metrics.one("light", "gauge", "How much of the picture the operator's fades leave, 0 to 1.", status.light);
  metrics.one("display_away", "gauge", "Whether the display is gone for now.", status.display_away ? 1 : 0);
  metrics.one("cue", "gauge", "The cue that plays, counted from 1.", status.show.cue + 1);
  metrics.one("frames_presented_total", "counter", "Frames shown, unchanged ones included.",
              counts.frames_presented);
  metrics.one("frames_unchanged_total", "counter", "Of these: not warped, since nothing had changed.",
              counts.frames_unchanged);
  metrics.one("frames_nv12_total", "counter", "Of the shown: live ones in NV12, without conversion.",
              counts.frames_nv12);
  metrics.one("frames_late_total", "counter", "Shown more than half a period after their time.",
              counts.frames_late);
  metrics.family("frames_dropped_total", "counter",
                 "Times of the show without a frame of their own, by the first stage that was late.");
  metrics.sample("frames_dropped_total", counts.dropped_by_faces, "cause=\"faces\"");
  metrics.sample("frames_dropped_total", counts.dropped_by_warp, "cause=\"warp\"");
  metrics.sample("frames_dropped_total", counts.dropped_by_display, "cause=\"display\"");
  metrics.one("frames_failed_total", "counter", "Times at which the faces could not be had.",
              counts.frames_failed);
  const FileCounts& files = status.show.files;
  metrics.family("files_frames_total", "counter",
                 "Frames of files: decoded, or not there when they were due.");
  metrics.sample("files_frames_total", files.decoded, "is=\"decoded\"");
  metrics.sample("files_frames_total", files.late, "is=\"late\"");
  metrics.sample("files_frames_total", files.sought, "is=\"sought\"");
  metrics.sample("files_frames_total", files.broken, "is=\"broken\"");
  if (const FileQueue& queue = status.show.queue; queue.most > 0) {
    metrics.one("queue_frames", "gauge", "Decoded ahead of the cue that plays and not shown yet.",
                queue.frames);
    metrics.one("queue_frames_most", "gauge", "That this queue holds.", queue.most);
  }
  metrics.one("frames_unshown_total", "counter", "Presented to a display that was away.",
              counts.frames_unshown);
  metrics.one("frames_blackout_total", "counter", "Of those shown: black by wish.", counts.blackout_frames);
  metrics.one("display_losses_total", "counter", "Times that the display went away.", counts.display_losses);
  metrics.one("preview_bytes_copied_total", "counter", "Copied by the frame loop for the control page.",
              counts.preview_bytes_copied);
  metrics.histogram("warp_seconds", "Time to warp a frame.", counts.warp);
  metrics.histogram("faces_seconds", "Time to get a frame's faces; live ones wait for the flip's sake.",
                    counts.faces);
  add_sound(metrics, status);
  add_osc(metrics, status.osc);
  add_cameras(metrics, status.show, facts);
  const auto zones = temperatures();
  if (!zones.empty()) metrics.family("temperature_celsius", "gauge", "Of the kernel's thermal zones.");
  for (const auto& [zone, degrees] : zones)
    metrics.sample("temperature_celsius", degrees, label("zone", zone));
  return metrics.text();
}

std::string status_text(const std::string& status_json) {
  try {
    const Json status = Json::parse(status_json);
    const Json& frames = status.at("frames");
    const std::string length = status.at("duration_s").is_null()
                                   ? ""
                                   : fmt::format(" of {:.1f}", status.at("duration_s").get<double>());
    const std::string pattern = status.at("test_pattern").get<std::string>();
    const std::string laid = pattern.empty() ? "" : ", test pattern " + pattern;
    std::string text = fmt::format(
        "{}: {}{}\ncue {} of {}, {}: {:.1f}{} s\n{}, {:.2f} Hz{}: {} frames, {} late, {} dropped, {} failed\n"
        "warp {:.1f} ms\n",
        status.at("show").get<std::string>(), status.at("state").get<std::string>(),
        std::string(status.at("blackout").get<bool>() ? ", dark" : "") + laid, status.at("cue").get<int>(),
        status.at("cues").get<int>(), status.at("cue_name").get<std::string>(),
        status.at("position_s").get<double>(), length, status.at("display").get<std::string>(),
        status.at("rate_hz").get<double>(), status.at("display_away").get<bool>() ? ", away" : "",
        frames.at("presented").get<std::int64_t>(), frames.at("late").get<std::int64_t>(),
        frames.at("dropped").get<std::int64_t>(), frames.at("failed").get<std::int64_t>(),
        status.at("warp_ms").get<double>());
    if (status.contains("sound")) text += sound_line(status.at("sound"));
    for (const Json& camera : status.at("cameras")) {
      text += fmt::format("camera of view {}: {}, {} frames, {} dropped, {} losses, {:+.2f} ms\n",
                          camera.at("view").get<std::string>(), camera.at("shows").get<std::string>(),
                          camera.at("frames").get<std::int64_t>(), camera.at("dropped").get<std::int64_t>(),
                          camera.at("losses").get<std::int64_t>(), camera.at("offset_ms").get<double>());
    }
    const std::string trouble = status.at("trouble").get<std::string>();
    const std::string reload = status.at("reload_trouble").get<std::string>();
    if (!reload.empty()) text += fmt::format("reload: {}; the show goes on as it was\n", reload);
    return trouble.empty() ? text : text + trouble + "\n";
  } catch (const Json::exception&) {
    throw Failure("what answers there is no player of this version");
  }
}

PlayerCommand parse_command_json(const std::string& body, const ShowFacts& facts) {
  constexpr const char* kExpected =
      R"(expected JSON like {"command": "next"} or {"command": "seek", "argument": 12.5})";
  const Json json = Json::parse(body, nullptr, false);
  if (!json.is_object() || !json.contains("command") || !json["command"].is_string()) {
    throw InputError(kExpected);
  }
  for (const auto& [key, value] : json.items()) {
    if (key != "command" && key != "argument") throw InputError(fmt::format("\"{}\": {}", key, kExpected));
  }
  std::string argument;
  if (const auto found = json.find("argument"); found != json.end()) {
    if (found->is_string()) {
      argument = found->get<std::string>();
    } else if (found->is_number()) {
      argument = found->dump();
    } else {
      throw InputError(fmt::format("argument: expected a text or a number; {}", kExpected));
    }
  }
  return parse_command(json["command"].get<std::string>(), argument, facts.cues);
}

}  // namespace cupola
