// The sound's figures as JSON and as a line.
// SPDX-License-Identifier: MIT
#include "firmware/sound_text.h"

#include <fmt/format.h>

namespace cupola {

nlohmann::ordered_json describe(const SoundReport& sound) {
  return {{"working", sound.working},        {"sounding", sound.sounding},
          {"master", sound.master},          {"rate_hz", sound.rate},
          {"channels", sound.channels},      {"drift_ms", 1e-6 * static_cast<double>(sound.drift.count())},
          {"device_ppm", sound.device_ppm},  {"applied_ppm", sound.applied_ppm},
          {"underruns", sound.underruns},    {"losses", sound.losses},
          {"frames_missing", sound.missing}, {"packets_damaged", sound.damaged},
          {"trouble", sound.trouble.data()}};
}

std::string sound_line(const nlohmann::ordered_json& sound) {
  if (!sound.at("working").get<bool>())
    return fmt::format("sound away: {}\n", sound.at("trouble").get<std::string>());
  return fmt::format("sound{} {:+.1f} ms, device {:+.0f} ppm, {} underruns, {} losses\n",
                     sound.at("master").get<bool>() ? " (master)" : "", sound.at("drift_ms").get<double>(),
                     sound.at("device_ppm").get<double>(), sound.at("underruns").get<std::int64_t>(),
                     sound.at("losses").get<std::int64_t>());
}

}  // namespace cupola
