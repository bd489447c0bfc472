// Fuzzes OSC packets: any bytes ask for what a text would, or are an InputError; none guesses a token.
// SPDX-License-Identifier: MIT
#include <cstddef>
#include <cstdint>
#include <cstdlib>
#include <string>
#include <vector>

#include "firmware/osc_packet.h"
#include "pipeline/frame/error.h"

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  using namespace cupola;
  const std::vector<std::string> cues = {"opening", "dome"};
  try {
    for (const OscMessage& message : read_osc_packet({data, size})) {
      const std::string again = osc_packet(message);
      const auto read = read_osc_packet({reinterpret_cast<const std::uint8_t*>(again.data()), again.size()});
      if (read.size() != 1 || read[0].address != message.address ||
          read[0].values.size() != message.values.size()) {
        std::abort();
      }
      try {
        if (osc_word(message.address, "the-token") &&
            message.address.find("/the-token/") == std::string::npos)
          std::abort();
      } catch (const InputError&) {
      }
      try {
        const auto word = osc_word(message.address, "");
        if (!word || *word == "status") continue;
        const auto command = parse_osc_command(*word, message.values, cues);
        if (command && describe(*command, cues).empty()) std::abort();
      } catch (const InputError&) {
      }
    }
  } catch (const InputError&) {
  }
  return 0;
}
