// OSC packets as liblo's senders make them, and such as nobody should; and what they mean.
// SPDX-License-Identifier: MIT
#include "firmware/osc_packet.h"

#include <gmock/gmock.h>
#include <lo/lo.h>

#include <cstdlib>
#include <limits>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using testing::HasSubstr;

const std::vector<std::string> kCues = {"opening", "dome", "7"};

std::vector<OscMessage> read(const std::string& packet) {
  return read_osc_packet({reinterpret_cast<const std::uint8_t*>(packet.data()), packet.size()});
}

std::string refusal_of(const std::string& packet) {
  try {
    read(packet);
  } catch (const InputError& error) {
    return error.what();
  }
  return "read";
}

std::string taken(void* bytes, std::size_t size) {
  const std::string packet(static_cast<const char*>(bytes), size);
  std::free(bytes);
  return packet;
}

// As oscsend makes it.
std::string message(const char* address, lo_message made) {
  std::size_t size = 0;
  void* const bytes = lo_message_serialise(made, address, nullptr, &size);
  lo_message_free(made);
  return taken(bytes, size);
}

std::optional<PlayerCommand> parsed(const char* word, std::vector<OscValue> values) {
  return parse_osc_command(word, values, kCues);
}

TEST(OscPacket, HasTheValuesThatLibloSends) {
  lo_message made = lo_message_new();
  lo_message_add(made, "ihfdsSTFI", -3, std::int64_t{1} << 40, 12.5F, 0.25, "text", "symbol");
  const std::vector<OscMessage> messages = read(message("/cupola/any", made));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].address, "/cupola/any");
  const std::vector<OscValue> expected = {std::int64_t{-3},    std::int64_t{1} << 40, 12.5, 0.25,
                                          std::string("text"), std::string("symbol"), true, false,
                                          OscImpulse()};
  EXPECT_TRUE(messages[0].values == expected);
}

TEST(OscPacket, MayLackTypesWhereItHasNoValues) {
  const std::vector<OscMessage> messages = read(std::string("/cupola/go\0\0", 12));
  ASSERT_EQ(messages.size(), 1U);
  EXPECT_EQ(messages[0].address, "/cupola/go");
  EXPECT_TRUE(messages[0].values.empty());
}

// A bundle of "/a", of a bundle of "/b", and of "/c".
std::string nested(lo_timetag outside, lo_timetag inside) {
  lo_bundle inner = lo_bundle_new(inside);
  lo_bundle_add_message(inner, "/b", lo_message_new());
  lo_bundle outer = lo_bundle_new(outside);
  lo_bundle_add_message(outer, "/a", lo_message_new());
  lo_bundle_add_bundle(outer, inner);
  lo_bundle_add_message(outer, "/c", lo_message_new());
  std::size_t size = 0;
  void* const bytes = lo_bundle_serialise(outer, nullptr, &size);
  lo_bundle_free_recursive(outer);
  return taken(bytes, size);
}

std::vector<OscTime> times(const std::string& packet) {
  std::vector<OscTime> times;
  for (const OscMessage& one : read(packet)) times.push_back(one.time);
  return times;
}

TEST(OscPacket, HasTheMessagesOfItsBundlesInTheirOrder) {
  std::string order;
  for (const OscMessage& one : read(nested(lo_timetag{0, 1}, lo_timetag{0, 1}))) order += one.address;
  EXPECT_EQ(order, "/a/b/c");
}

TEST(OscPacket, HasItsBundlesTimes) {
  const OscTime early = OscTime{0xee00'0000} << 32U | 0x8000'0001U;
  const OscTime late = early + 1;
  const lo_timetag now = {0, 1};
  const lo_timetag none = {0, 0};
  const lo_timetag first = {0xee00'0000, 0x8000'0001};
  const lo_timetag second = {0xee00'0000, 0x8000'0002};
  EXPECT_EQ(times(message("/a", lo_message_new())), std::vector<OscTime>{kOscAtOnce});
  EXPECT_EQ(times(nested(first, second)), (std::vector<OscTime>{early, late, early}));
  EXPECT_EQ(times(nested(first, first)), (std::vector<OscTime>{early, early, early}));
  EXPECT_EQ(times(nested(now, first)), (std::vector<OscTime>{kOscAtOnce, early, kOscAtOnce}));
  EXPECT_EQ(times(nested(first, now)), (std::vector<OscTime>{early, early, early}));
  EXPECT_EQ(times(nested(none, none)), (std::vector<OscTime>{kOscAtOnce, kOscAtOnce, kOscAtOnce}));
}

TEST(OscPacket, HasNoBundleThatCountsBeforeTheOneAroundIt) {
  const lo_timetag first = {0xee00'0000, 0x8000'0001};
  const lo_timetag second = {0xee00'0000, 0x8000'0002};
  EXPECT_THAT(refusal_of(nested(second, first)), HasSubstr("to count before the one around it"));
  const lo_timetag before_2036 = {0xffff'ffff, 0};
  const lo_timetag after_2036 = {0, 2};
  EXPECT_EQ(refusal_of(nested(before_2036, after_2036)), "read");
  EXPECT_THAT(refusal_of(nested(after_2036, before_2036)), HasSubstr("to count before the one around it"));
}

TEST(OscPacket, IsRefusedWholeWhereItIsIllFormed) {
  lo_message made = lo_message_new();
  lo_message_add(made, "fs", 1.0F, "abc");
  const std::string good = message("/cupola/seek", made);
  for (std::size_t length = 0; length < good.size(); ++length) {
    if (length == 16) continue;  // an address alone is a message
    EXPECT_NE(refusal_of(good.substr(0, length)), "read") << length;
  }
  EXPECT_NE(refusal_of("cupola/go\0\0\0"), "read");
  EXPECT_NE(refusal_of("GET / HTTP/1.1\r\n"), "read");
  EXPECT_THAT(refusal_of(std::string(5000, '/')), HasSubstr("over 4096 bytes"));
  const std::string header("#bundle\0\0\0\0\0\0\0\0\1", 16);
  EXPECT_EQ(refusal_of(header), "read");  // an empty one
  EXPECT_THAT(refusal_of(header + std::string("\0\0\1\0/a\0\0", 8)), HasSubstr("ill-formed OSC bundle"));
  EXPECT_THAT(refusal_of(header + std::string("\xff\xff\xff\xff", 4)), HasSubstr("ill-formed OSC bundle"));
  std::string deep = std::string("/a\0\0", 4);
  for (int i = 0; i < 20; ++i) {
    deep = header + std::string("\0\0", 2) + static_cast<char>(deep.size() / 256) +
           static_cast<char>(deep.size() % 256) + deep;
  }
  EXPECT_THAT(refusal_of(deep), HasSubstr("ill-formed OSC bundle"));
  lo_message blob = lo_message_new();
  lo_message_add_timetag(blob, lo_timetag{0, 1});
  EXPECT_THAT(refusal_of(message("/cupola/go", blob)), HasSubstr("a value of a type other than"));
}

TEST(OscAddress, IsTheCommandAfterTheTokenIfThereIsOne) {
  EXPECT_EQ(osc_word("/cupola/go", ""), "go");
  EXPECT_EQ(osc_word("/cupola/sixteen-letters!/go", "sixteen-letters!"), "go");
  EXPECT_EQ(osc_word("/cupola/a/slash/in/it/go", "a/slash/in/it"), "go");
  for (const char* address : {"/cupola/go", "/cupola/sixteen-letters?/go", "/cupola/sixteen-letters!go",
                              "/cupola/sixteen-letters!", "/cupola/", "/cupola/sixteen"}) {
    EXPECT_EQ(osc_word(address, "sixteen-letters!"), std::nullopt) << address;
  }
  EXPECT_THROW(osc_word("/qlab/go", ""), InputError);
  EXPECT_THROW(osc_word("/qlab/go", "sixteen-letters!"), InputError);
}

TEST(OscCommand, TakesNumbersAndTextsAsTheOthersTakeText) {
  EXPECT_EQ(parsed("seek", {12.5}), parse_command("seek", "12.5", kCues));
  EXPECT_EQ(parsed("seek", {std::int64_t{12}}), parse_command("seek", "12", kCues));
  EXPECT_EQ(parsed("seek", {std::string("12.5")}), parse_command("seek", "12.5", kCues));
  EXPECT_EQ(parsed("cue", {std::int64_t{2}}), parse_command("cue", "dome", kCues));
  EXPECT_EQ(parsed("cue", {2.0}), parse_command("cue", "dome", kCues));
  EXPECT_EQ(parsed("cue", {std::string("dome")}), parse_command("cue", "dome", kCues));
  EXPECT_EQ(parsed("cue", {std::int64_t{7}}), parse_command("cue", "7", kCues));  // names go first
  EXPECT_EQ(parsed("fade", {std::string("out"), 2.5}), parse_command("fade", "out 2.5", kCues));
  EXPECT_EQ(parsed("fade", {}), parse_command("fade", "", kCues));
  EXPECT_EQ(parsed("volume", {79.6}), parse_command("volume", "80", kCues));  // a fader
  EXPECT_EQ(parsed("volume", {std::string("+5")}), parse_command("volume", "+5", kCues));
  EXPECT_EQ(parsed("test-pattern", {std::string("grid")}), parse_command("test-pattern", "grid", kCues));
}

TEST(OscCommand, IsGivenByPressingAButtonAndNotByLettingItGo) {
  const PlayerCommand go = parse_command("go", "", kCues);
  for (const OscValue& press : std::vector<OscValue>{1.0, std::int64_t{1}, true, OscImpulse(), 0.5})
    EXPECT_EQ(parsed("go", {press}), go);
  EXPECT_EQ(parsed("go", {}), go);
  for (const OscValue& release : std::vector<OscValue>{0.0, std::int64_t{0}, false})
    EXPECT_EQ(parsed("go", {release}), std::nullopt);
}

TEST(OscCommand, SwitchesTheBlackout) {
  for (const OscValue& on : std::vector<OscValue>{1.0, std::int64_t{1}, true, std::string("on")})
    EXPECT_EQ(parsed("blackout", {on})->action, PlayerAction::kBlackout);
  for (const OscValue& off : std::vector<OscValue>{0.0, std::int64_t{0}, false, std::string("off")})
    EXPECT_EQ(parsed("blackout", {off})->action, PlayerAction::kBlackoutOff);
  EXPECT_EQ(parsed("blackout", {})->action, PlayerAction::kBlackoutToggle);
  EXPECT_EQ(parsed("blackout", {OscImpulse()})->action, PlayerAction::kBlackoutToggle);
}

TEST(OscCommand, OfWrongValuesIsRefused) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinite = std::numeric_limits<double>::infinity();
  EXPECT_THROW(parsed("seek", {}), InputError);
  EXPECT_THROW(parsed("seek", {true}), InputError);
  EXPECT_THROW(parsed("seek", {nan}), InputError);
  EXPECT_THROW(parsed("seek", {infinite}), InputError);
  EXPECT_THROW(parsed("seek", {1.0, 2.0}), InputError);
  EXPECT_THROW(parsed("volume", {nan}), InputError);
  EXPECT_THROW(parsed("volume", {1e300}), InputError);
  EXPECT_THROW(parsed("volume", {std::int64_t{101}}), InputError);
  EXPECT_THROW(parsed("cue", {2.4}), InputError);
  EXPECT_THROW(parsed("go", {std::string("now")}), InputError);
  EXPECT_THROW(parsed("go", {1.0, 1.0}), InputError);
  EXPECT_THROW(parsed("goo", {}), InputError);
  EXPECT_THROW(parsed("", {}), InputError);
}

TEST(OscCommand, IsRefusedInOneLine) {
  try {
    parsed("cue", {std::string("a\nb\x1b[2J")});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), HasSubstr("\"a?b?[2J\""));
  }
}

}  // namespace
}  // namespace cupola
