// A line is written at once, so that those of other threads do not come into it.
// SPDX-License-Identifier: MIT
#include "firmware/log_writer.h"

#include <fmt/format.h>

#include <nlohmann/json.hpp>

namespace cupola {

std::string written_as(LogForm form, const EventLog::Line& line) {
  if (form == LogForm::kText) return fmt::format("cupola: {}\n", line.text);
  const nlohmann::ordered_json json = {{"time", utc_text(line.at)},
                                       {"number", line.number},
                                       {"severity", name_of(line.severity)},
                                       {"topic", name_of(line.topic)},
                                       {"text", line.text}};
  return json.dump(-1, ' ', false, nlohmann::json::error_handler_t::replace) + "\n";
}

LogWriter::LogWriter(EventLog& log, LogForm form, std::FILE* to)
    : log_(log), form_(form), to_(to), side_([this] { write(); }, false) {
  log_.ring(&side_);
  side_.ring();
}

LogWriter::~LogWriter() {
  log_.ring(nullptr);
  side_.finish();
  write();
}

void LogWriter::write() {
  for (const EventLog::Line& line : log_.lines(written_, least_of(form_))) {
    written_ = line.number;
    std::fputs(written_as(form_, line).c_str(), to_);
  }
  std::fflush(to_);
}

}  // namespace cupola
