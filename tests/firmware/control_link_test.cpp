// What the loop shares with others, under threads.
// SPDX-License-Identifier: MIT
#include "firmware/control_link.h"

#include <gtest/gtest.h>
#include <unistd.h>

#include <array>
#include <cstdio>
#include <cstdlib>
#include <nlohmann/json.hpp>
#include <sstream>
#include <thread>

#include "firmware/log_writer.h"

namespace cupola {
namespace {

TEST(Snapshot, IsNeverHalfOfOneAndHalfOfAnother) {
  struct Pair {
    std::int64_t a = 0;
    std::array<std::int64_t, 64> b{};
  };
  Snapshot<Pair> snapshot;
  std::thread writer([&] {
    for (std::int64_t i = 1; i <= 20'000; ++i) {
      Pair pair{i, {}};
      pair.b.fill(-i);
      snapshot.publish(pair);
    }
  });
  std::int64_t newest = 0;
  for (int i = 0; i < 5000; ++i) {
    const Pair pair = snapshot.read();
    for (const std::int64_t b : pair.b) ASSERT_EQ(b, -pair.a);
    ASSERT_GE(pair.a, newest) << "never runs backwards";
    newest = pair.a;
  }
  writer.join();
}

TEST(Snapshot, HasTheLastValueWhenNobodyReadMeanwhile) {
  Snapshot<int> snapshot;
  for (int i = 0; i < 10; ++i) snapshot.publish(i);
  EXPECT_EQ(snapshot.read(), 9);
}

TEST(EventLog, KeepsTheLastLinesInOrder) {
  EventLog log;
  EXPECT_TRUE(log.lines().empty());
  log.info(Topic::kShow, "one");
  log.warn(Topic::kSound, "two");
  std::vector<EventLog::Line> lines = log.lines();
  ASSERT_EQ(lines.size(), 2U);
  EXPECT_EQ(lines[0].text, "one");
  EXPECT_EQ(lines[0].number, 1);
  EXPECT_EQ(lines[1].severity, Severity::kWarning);
  EXPECT_EQ(lines[1].topic, Topic::kSound);
  EXPECT_EQ(log.lines(1).size(), 1U);
  for (std::size_t i = 0; i < EventLog::kLines; ++i) {
    log.info(Topic::kShow, std::to_string(i));
    log.lines();
  }
  lines = log.lines();
  ASSERT_EQ(lines.size(), EventLog::kLines);
  EXPECT_EQ(lines.front().text, "0");
  EXPECT_EQ(lines.back().text, std::to_string(EventLog::kLines - 1));
  EXPECT_EQ(lines.back().number, static_cast<std::int64_t>(EventLog::kLines) + 2);
}

TEST(EventLog, CutsLongLines) {
  EventLog log;
  log.info(Topic::kShow, std::string(1000, 'x'));
  EXPECT_EQ(log.lines()[0].text, std::string(EventLog::kLongest, 'x'));
}

TEST(EventLog, CountsWhatCameTooFast) {
  EventLog log;
  for (int i = 0; i < 100; ++i) log.info(Topic::kShow, std::to_string(i));
  const std::vector<EventLog::Line> lines = log.lines();
  ASSERT_EQ(lines.size(), 65U);
  EXPECT_EQ(lines[63].text, "63");
  EXPECT_EQ(lines[64].text, "36 lines of the log came too fast to be kept");
  EXPECT_EQ(lines[64].severity, Severity::kWarning);
}

TEST(EventLog, TakesLinesFromManyThreads) {
  EventLog log;
  std::thread other([&] {
    for (int i = 0; i < 2000; ++i) log.info(Topic::kShow, "aaaaaaaaaaaaaaaa");
  });
  for (int i = 0; i < 2000; ++i) {
    log.info(Topic::kShow, "bbbbbbbbbbbb");
    if (i % 100 != 0) continue;
    std::int64_t before = 0;
    for (const EventLog::Line& line : log.lines()) {
      EXPECT_TRUE(line.text == "aaaaaaaaaaaaaaaa" || line.text == "bbbbbbbbbbbb" ||
                  line.text.ends_with("too fast to be kept"))
          << line.text;
      EXPECT_GT(line.number, before);
      before = line.number;
    }
  }
  other.join();
}

// A file in memory that is read when it is closed.
struct Written {
  char* text = nullptr;
  std::size_t length = 0;
  std::FILE* file = open_memstream(&text, &length);
  std::string close() {
    std::fclose(file);
    std::string all(text, length);
    std::free(text);
    return all;
  }
};

TEST(LogWriter, SaysWhatAnOperatorShouldKnow) {
  Written written;
  {
    EventLog log;
    const LogWriter writer(log, LogForm::kText, written.file);
    log.info(Topic::kShow, "cue 2");
    log.notice(Topic::kDisplay, "the display is back");
    log.warn(Topic::kDisplay, "the projector is on fire");
  }
  EXPECT_EQ(written.close(), "cupola: the display is back\ncupola: the projector is on fire\n");
}

TEST(LogWriter, WritesAllAsJsonForMachines) {
  Written written;
  {
    EventLog log;
    const LogWriter writer(log, LogForm::kJson, written.file);
    log.info(Topic::kShow, "cue 2: \"stars\"\n\xff");
    log.warn(Topic::kSound, "away");
  }
  std::istringstream lines(written.close());
  std::string line;
  ASSERT_TRUE(std::getline(lines, line));
  const auto first = nlohmann::json::parse(line);
  EXPECT_EQ(first["number"], 1);
  EXPECT_EQ(first["severity"], "info");
  EXPECT_EQ(first["topic"], "show");
  EXPECT_EQ(first["text"], "cue 2: \"stars\"\n\uFFFD");
  ASSERT_TRUE(std::getline(lines, line));
  EXPECT_EQ(nlohmann::json::parse(line)["severity"], "warning");
  EXPECT_FALSE(std::getline(lines, line));
}

TEST(LogWriter, HoldsUpNobodyWhenNobodyReadsTheStream) {
  int ends[2];
  ASSERT_EQ(pipe(ends), 0);
  std::FILE* const file = fdopen(ends[1], "w");
  std::jthread reader;
  {
    EventLog log;
    const LogWriter writer(log, LogForm::kText, file);
    const std::string text(EventLog::kLongest, 'x');
    for (int i = 0; i < 1000; ++i) {  // a pipe holds 64 KiB
      log.warn(Topic::kShow, text);
      ASSERT_FALSE(log.lines().empty()) << "others read meanwhile";
    }
    reader = std::jthread([&] {
      std::array<char, 65536> taken;  // NOLINT(cppcoreguidelines-pro-type-member-init)
      while (read(ends[0], taken.data(), taken.size()) > 0) {
      }
    });
  }
  std::fclose(file);
  reader.join();
  close(ends[0]);
}

TEST(UtcText, HasThousandths) {
  EXPECT_EQ(utc_text(WallTime(std::chrono::milliseconds(1769903999123))), "2026-01-31T23:59:59.123Z");
  EXPECT_EQ(utc_text(WallTime(std::chrono::seconds(0))), "1970-01-01T00:00:00.000Z");
}

}  // namespace
}  // namespace cupola
