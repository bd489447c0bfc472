// The log's lines on standard error, for people or for machines that collect them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <cstdio>
#include <string>

#include "firmware/event_log.h"
#include "firmware/side_work.h"

namespace cupola {

enum class LogForm : std::uint8_t {
  kText,  // "cupola: TEXT", notices and warnings only
  kJson,  // an object a line: time (UTC), number, severity, topic, text
};

// The least severe lines that the form has.
constexpr Severity least_of(LogForm form) {
  return form == LogForm::kText ? Severity::kNotice : Severity::kInfo;
}

// With its line end.
std::string written_as(LogForm form, const EventLog::Line& line);

// On a thread of its own: whoever reads the stream slowly holds up nobody else. Allocates for what it writes.
class LogWriter {
 public:
  // `log` and `to` are borrowed.
  LogWriter(EventLog& log, LogForm form, std::FILE* to);
  ~LogWriter();  // when all is written; nobody may add lines meanwhile
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

 private:
  void write();

  EventLog& log_;
  const LogForm form_;
  std::FILE* const to_;
  std::int64_t written_ = 0;  // the last line's number
  SideWork side_;             // last: it uses the others
};

}  // namespace cupola
