// From the file to the timeline, and to the commands that make it as it was.
// SPDX-License-Identifier: MIT
#include "firmware/resume_show.h"

#include <fmt/format.h>

#include <fstream>
#include <optional>

#include "firmware/show_position.h"
#include "pipeline/frame/error.h"

namespace cupola {

void resume_show(const std::string& file, ShowFrames& frames, const ShowFacts& facts, ControlLink& link) {
  constexpr std::streamsize kLongest = 65536;
  std::ifstream in(file, std::ios::binary);
  if (!in) return;  // there was no show before
  std::string text(static_cast<std::size_t>(kLongest), '\0');
  in.read(text.data(), kLongest);
  text.resize(static_cast<std::size_t>(in.gcount()));
  try {
    const ShowPosition position = parse_position(text);
    if (position.show != facts.show) {
      return link.log.warn(Topic::kShow, fmt::format("{}: is of the show {}; {} begins at its start", file,
                                                     position.show, facts.show));
    }
    const std::optional<Resumption> place = resume_at(position, facts.cues, instant_now());
    if (!place) {
      return link.log.warn(Topic::kShow, fmt::format("{}: there is no cue {}; the show begins at its start",
                                                     file, position.cue_name));
    }
    if (!frames.begin_in(place->cue, place->played)) {
      return link.log.warn(Topic::kShow,
                           fmt::format("{}: the show would be over; it begins at its start", file));
    }
    if (position.volume) link.commands.push({.action = PlayerAction::kVolume, .volume = *position.volume});
    if (position.held) link.commands.push({PlayerAction::kPause});
    if (position.dark) link.commands.push({PlayerAction::kBlackout});
    link.log.notice(Topic::kShow,
                    fmt::format("resumed from cue {}, which began {:.1f} s ago", facts.cues[place->cue],
                                static_cast<double>(place->played.count()) / 1e9));
  } catch (const InputError& error) {
    link.log.warn(Topic::kShow, fmt::format("{}: {}; the show begins at its start", file, error.what()));
  }
}

}  // namespace cupola
