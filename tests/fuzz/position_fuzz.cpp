// Fuzzes the position file's reader: any file is a position, read as written, or an InputError.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/show_position.h"
#include "pipeline/frame/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  try {
    const cupola::ShowPosition read = cupola::parse_position({reinterpret_cast<const char*>(data), size});
    const cupola::ShowPosition again = cupola::parse_position(cupola::position_text(read));
    if (again.cue != read.cue || again.position != read.position || again.cue_name != read.cue_name)
      std::abort();
    const std::vector<std::string> cues = {"a", read.cue_name};
    const auto place = cupola::resume_at(read, cues, {read.at.boot, std::chrono::nanoseconds(5), {}});
    if (!place || place->played < std::chrono::nanoseconds(0)) std::abort();
  } catch (const cupola::InputError&) {
  }
  return 0;
}
