// How the sound fares, for stats, status and metrics.
// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <string>

#include "firmware/sound_report.h"

namespace cupola {

nlohmann::ordered_json describe(const SoundReport& sound);

// The line of `cupola status`, from describe(): "sound in step, +0.3 ms, ...".
std::string sound_line(const nlohmann::ordered_json& sound);

}  // namespace cupola
