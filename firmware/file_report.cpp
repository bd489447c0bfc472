// File counts as JSON.
// SPDX-License-Identifier: MIT
#include "firmware/file_report.h"

#include <algorithm>

namespace cupola {

nlohmann::ordered_json describe(const FileCounts& counts) {
  const auto decoded = static_cast<double>(std::max<std::int64_t>(counts.decoded, 1));
  return {{"frames_decoded", counts.decoded},
          {"frames_late", counts.late},
          {"frames_sought", counts.sought},
          {"frames_broken", counts.broken},
          {"decode_ms_mean", 1e-6 * static_cast<double>(counts.decode_ns) / decoded},
          {"decode_ms_max", 1e-6 * static_cast<double>(counts.longest_ns)},
          {"bytes_ahead", counts.bytes_ahead}};
}

}  // namespace cupola
