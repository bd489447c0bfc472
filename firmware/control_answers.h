// What the player answers those who control it: JSON, and text for Prometheus.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "firmware/event_log.h"
#include "firmware/player_command.h"
#include "firmware/player_status.h"
#include "firmware/show.h"
#include "firmware/show_facts.h"

namespace cupola {

ShowFacts facts_of(const Show& show, const std::string& display);

// The views that the cue shown has pictures of.
std::vector<std::string> views_of(const ShowFacts& facts, const PlayerStatus& status);
// `reload_trouble`: why the last reload changed nothing.
std::string status_json(const PlayerStatus& status, const ShowFacts& facts,
                        const std::string& reload_trouble = "");
std::string cues_json(const PlayerStatus& status, const ShowFacts& facts);
std::string log_json(const std::vector<EventLog::Line>& lines);
std::string error_json(std::string_view error);
// Prometheus' text format 0.0.4.
std::string metrics_text(const PlayerStatus& status, const ShowFacts& facts);
// The same lines for a terminal.
std::string status_text(const std::string& status_json);

// {"command": "seek", "argument": 12.5}; the argument may be a text, a number, or missing. Throws InputError.
PlayerCommand parse_command_json(const std::string& body, const ShowFacts& facts);

}  // namespace cupola
