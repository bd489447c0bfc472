// What the loop shares with others, under threads.
// SPDX-License-Identifier: MIT
#include "firmware/control_link.h"

#include <gtest/gtest.h>

#include <thread>

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
  log.note("one");
  log.note("two");
  ASSERT_EQ(log.lines().size(), 2U);
  EXPECT_EQ(log.lines()[0].text, "one");
  EXPECT_EQ(log.lines()[0].number, 1);
  for (std::size_t i = 0; i < EventLog::kLines; ++i) log.note(std::to_string(i));
  const std::vector<EventLog::Line> lines = log.lines();
  ASSERT_EQ(lines.size(), EventLog::kLines);
  EXPECT_EQ(lines.front().text, "0");
  EXPECT_EQ(lines.back().text, std::to_string(EventLog::kLines - 1));
  EXPECT_EQ(lines.back().number, static_cast<std::int64_t>(EventLog::kLines) + 2);
}

TEST(EventLog, CutsLongLines) {
  EventLog log;
  log.note(std::string(1000, 'x'));
  EXPECT_EQ(log.lines()[0].text, std::string(EventLog::kLongest, 'x'));
}

TEST(EventLog, SaysTroubleOnStandardError) {
  EventLog log;
  testing::internal::CaptureStderr();
  log.say("the projector is on fire");
  EXPECT_EQ(testing::internal::GetCapturedStderr(), "cupola: the projector is on fire\n");
  EXPECT_EQ(log.lines()[0].text, "the projector is on fire");
}

TEST(EventLog, TakesLinesFromManyThreads) {
  EventLog log;
  std::thread other([&] {
    for (int i = 0; i < 2000; ++i) log.note("aaaaaaaaaaaaaaaa");
  });
  for (int i = 0; i < 2000; ++i) {
    log.note("bbbbbbbbbbbb");
    if (i % 100 != 0) continue;
    std::int64_t before = 0;
    for (const EventLog::Line& line : log.lines()) {
      EXPECT_TRUE(line.text == "aaaaaaaaaaaaaaaa" || line.text == "bbbbbbbbbbbb") << line.text;
      EXPECT_GT(line.number, before);
      before = line.number;
    }
  }
  other.join();
}

}  // namespace
}  // namespace cupola
