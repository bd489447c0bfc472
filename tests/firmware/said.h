// What an operator reads of a log.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "firmware/log_writer.h"

namespace cupola {

inline std::string said(EventLog& log) {
  std::string text;
  for (const EventLog::Line& line : log.lines(0, least_of(LogForm::kText)))
    text += written_as(LogForm::kText, line);
  return text;
}

}  // namespace cupola
