// JSON, strictly read: the file may have been cut or made by anybody.
// SPDX-License-Identifier: MIT
#include "firmware/show_position.h"

#include <fmt/format.h>

#include <algorithm>
#include <nlohmann/json.hpp>

#include "hal/time/boot_time.h"
#include "hal/time/wall_time.h"
#include "pipeline/frame/error.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {

using Json = nlohmann::ordered_json;

constexpr std::int64_t kMostNanoseconds = std::int64_t{1} << 62;  // sums of two of them fit
constexpr std::size_t kLongestName = 4096;
constexpr std::int64_t kMostCues = 1'000'000;

[[noreturn]] void refuse() {
  throw InputError("expected a position that a player wrote");
}

std::int64_t number(const Json& json, const char* key, std::int64_t most) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_number_integer()) refuse();
  if (found->is_number_unsigned() && found->get<std::uint64_t>() > static_cast<std::uint64_t>(most)) refuse();
  const auto value = found->get<std::int64_t>();
  if (value < 0 || value > most) refuse();
  return value;
}

std::string text(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_string()) refuse();
  std::string value = found->get<std::string>();
  if (value.size() > kLongestName) refuse();
  return value;
}

bool flag(const Json& json, const char* key) {
  const auto found = json.find(key);
  if (found == json.end() || !found->is_boolean()) refuse();
  return found->get<bool>();
}

}  // namespace

Instant instant_now() {
  return {boot_id(), time_since_boot(),
          std::chrono::duration_cast<nanoseconds>(wall_time().time_since_epoch())};
}

nanoseconds between(const Instant& earlier, const Instant& later) {
  const bool same = !earlier.boot.empty() && earlier.boot == later.boot;
  return std::max(nanoseconds(0), same ? later.booted - earlier.booted : later.wall - earlier.wall);
}

std::string position_text(const ShowPosition& position) {
  Json json = {{"cupola_position", 1},
               {"show", position.show},
               {"cue", position.cue + 1},
               {"cue_name", position.cue_name},
               {"position_ns", position.position.count()},
               {"held", position.held},
               {"dark", position.dark},
               {"boot", position.at.boot},
               {"booted_ns", position.at.booted.count()},
               {"wall_ns", position.at.wall.count()}};
  if (position.volume) json["volume"] = *position.volume;
  return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

ShowPosition parse_position(std::string_view written) {
  // No deeper than the object itself: nesting takes stack.
  const auto flat = [](int depth, Json::parse_event_t, Json&) { return depth <= 1; };
  const Json json = Json::parse(written, flat, false);
  if (!json.is_object() || number(json, "cupola_position", 1) != 1) refuse();
  ShowPosition position;
  position.show = text(json, "show");
  const std::int64_t cue = number(json, "cue", kMostCues);
  if (cue < 1) refuse();
  position.cue = static_cast<std::size_t>(cue - 1);
  position.cue_name = text(json, "cue_name");
  position.position = nanoseconds(number(json, "position_ns", kMostNanoseconds));
  position.held = flag(json, "held");
  position.dark = flag(json, "dark");
  if (json.contains("volume")) position.volume = static_cast<int>(number(json, "volume", 100));
  position.at.boot = text(json, "boot");
  position.at.booted = nanoseconds(number(json, "booted_ns", kMostNanoseconds));
  position.at.wall = nanoseconds(number(json, "wall_ns", kMostNanoseconds));
  return position;
}

std::optional<Resumption> resume_at(const ShowPosition& position, std::span<const std::string> cues,
                                    const Instant& now) {
  std::size_t cue = position.cue;
  if (cue >= cues.size() || cues[cue] != position.cue_name) {
    cue = static_cast<std::size_t>(std::find(cues.begin(), cues.end(), position.cue_name) - cues.begin());
  }
  if (cue == cues.size()) return std::nullopt;
  return Resumption{cue, position.position + (position.held ? nanoseconds(0) : between(position.at, now))};
}

}  // namespace cupola
