// OSC's address patterns, by examples and against a slow obvious matcher.
// SPDX-License-Identifier: MIT
#include "firmware/osc_pattern.h"

#include <gmock/gmock.h>

#include <algorithm>
#include <random>
#include <string>

#include "firmware/osc_command.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using testing::HasSubstr;

const std::string kToken = "a-token-of-twenty-si";

// Tries every way, one after the other. For patterns whose brackets and braces are closed.
bool slowly_matches(std::string_view pattern, std::string_view part) {
  if (pattern.empty()) return part.empty();
  const char sign = pattern[0];
  if (sign == '*') {
    for (std::size_t taken = 0; taken <= part.size(); ++taken) {
      if (slowly_matches(pattern.substr(1), part.substr(taken))) return true;
    }
    return false;
  }
  if (sign == '{') {
    const std::size_t end = pattern.find('}');
    std::string_view list = pattern.substr(1, end - 1);
    for (;;) {
      const std::string_view text = list.substr(0, list.find(','));
      if (part.starts_with(text) && slowly_matches(pattern.substr(end + 1), part.substr(text.size()))) {
        return true;
      }
      if (text.size() == list.size()) return false;
      list.remove_prefix(text.size() + 1);
    }
  }
  if (part.empty()) return false;
  if (sign == '[') {
    const std::size_t end = pattern.find(']');
    const std::string_view set = pattern.substr(1, end - 1);
    std::string members;
    for (std::size_t i = set.starts_with('!') ? 1 : 0; i < set.size(); ++i) {
      if (i + 2 < set.size() && set[i + 1] == '-') {
        for (char c = std::min(set[i], set[i + 2]); c <= std::max(set[i], set[i + 2]); ++c) members += c;
        i += 2;
      } else {
        members += set[i];
      }
    }
    const bool found = members.find(part[0]) != members.npos;
    return found != set.starts_with('!') && slowly_matches(pattern.substr(end + 1), part.substr(1));
  }
  return (sign == '?' || sign == part[0]) && slowly_matches(pattern.substr(1), part.substr(1));
}

std::string refusal_of(const std::string& address, const std::string& token = "") {
  try {
    osc_word(address, token);
  } catch (const InputError& error) {
    return error.what();
  }
  return "taken";
}

TEST(OscPattern, MatchesAsTheStandardHasIt) {
  for (const char* pattern :
       {"go",    "g?",        "??",        "*",        "g*",       "*o",         "**",      "*go*",
        "{go}",  "{go,next}", "{next,go}", "{,g}{o,}", "[g]o",     "[a-z][a-z]", "[!a-f]o", "[z-a]o",
        "[!-]o", "g[o-]",     "g[-o]",     "{g,go}",   "{goo,g}o", "*[o]"}) {
    EXPECT_TRUE(osc_matches(pattern, "go")) << pattern;
  }
  for (const char* pattern : {"", "g", "goo", "?", "???", "o*", "*g", "{}", "{next}", "{g}", "[o]o", "[!g]o",
                              "[]o", "[a-f]o", "{g?}", "g[!n-p]", "*{a,b}*", "go{next}"}) {
    EXPECT_FALSE(osc_matches(pattern, "go")) << pattern;
  }
  EXPECT_TRUE(osc_matches("[!]o", "go"));
  EXPECT_TRUE(osc_matches("a[!-!]", "a\""));  // a ! that is not the first means itself
  EXPECT_TRUE(osc_matches("*", ""));
  EXPECT_TRUE(osc_matches(std::string(128, '*'), std::string(63, 'x')));
  EXPECT_TRUE(osc_matches(std::string(63, '?'), std::string(63, 'x')));
}

TEST(OscPattern, MatchesWhatTryingEveryWayMatches) {
  std::mt19937 random(1);
  const auto any = [&](std::string_view of) { return of[random() % of.size()]; };
  int matched = 0;
  for (int i = 0; i < 60'000; ++i) {
    std::string pattern;
    for (auto pieces = random() % 5; pieces > 0; --pieces) {
      const char sign = any("ab*?[{");
      pattern += sign;
      if (sign != '[' && sign != '{') continue;
      for (auto letters = random() % 5; letters > 0; --letters)
        pattern += any(sign == '[' ? "abc-!" : "abc,");
      pattern += sign == '[' ? ']' : '}';
    }
    std::string part;
    for (auto letters = random() % 6; letters > 0; --letters) part += any("abcd");
    ASSERT_EQ(osc_matches(pattern, part), slowly_matches(pattern, part)) << pattern << " " << part;
    matched += osc_matches(pattern, part) ? 1 : 0;
  }
  EXPECT_GT(matched, 2000);
}

TEST(OscPattern, IsRefusedWhereItIsIllFormedOrLong) {
  for (const char* pattern : {"[", "g[o", "{", "{go,", "]", "}", "g]o", "x[!", "*{a", "{a]", "[a}", "{[}]"}) {
    EXPECT_THROW(osc_matches(pattern, "go"), InputError) << pattern;
  }
  EXPECT_THROW(osc_matches(std::string(129, '*'), "go"), InputError);
}

// A matcher that goes back tries some 10^40 ways here.
TEST(OscPattern, TakesNoLongerForManyStars) {
  std::string pattern;
  for (int i = 0; i < 42; ++i) pattern += "*a?";
  EXPECT_FALSE(osc_matches(pattern + "b", std::string(63, 'a')));
}

TEST(OscAddressPattern, IsTheOneCommandThatItMatches) {
  for (const char* address : {"/cupola/{go}", "/cupola/g?", "/*/go", "/cup*/g[a-z]", "/{cupola,qlab}/go",
                              "/c??ola/{go,absent}", "/[!d]upola/go"}) {
    EXPECT_EQ(osc_word(address, ""), "go") << address;
  }
  EXPECT_EQ(osc_word("/cupola/pl?y", ""), "play");
  EXPECT_EQ(osc_word("/cupola/*pattern", ""), "test-pattern");
  EXPECT_EQ(osc_word("/*/stat*", ""), "status");
}

TEST(OscAddressPattern, OfSeveralCommandsOrNoneIsRefused) {
  EXPECT_EQ(refusal_of("/cupola/{next,go}"),
            "\"{next,go}\": expected a pattern of one command; it matches go, next");
  EXPECT_THAT(refusal_of("/cupola/*"), HasSubstr("it matches play, pause,"));
  EXPECT_THAT(refusal_of("/cupola/play*"), HasSubstr("it matches play, play-pause"));
  EXPECT_THAT(refusal_of("/cupola/x*"), HasSubstr("it matches none"));
  EXPECT_THAT(refusal_of("/cupola/{go"), HasSubstr("a { that no } follows"));
  EXPECT_THAT(refusal_of("/qlab*/go"), HasSubstr("expected an address like /cupola/go"));
  EXPECT_THAT(refusal_of("/*"), HasSubstr("expected an address like /cupola/go"));
}

TEST(OscAddressPattern, NeverReachesAcrossASlash) {
  for (const char* address : {"/*go", "/cupola*go", "/cupola?go", "/cupola[/]go", "/{cupola/go,go}"}) {
    EXPECT_NE(refusal_of(address), "taken") << address;
  }
  for (const char* word : {"*/go", "go/*", "[!/]o", "{go/x,go}"}) {
    EXPECT_EQ(osc_word(std::string("/cupola/") + word, ""), word) << "no command";
  }
}

TEST(OscAddressPattern, IsNoWayRoundTheToken) {
  EXPECT_EQ(osc_word("/cupola/" + kToken + "/{go}", kToken), "go");
  EXPECT_EQ(osc_word("/*/" + kToken + "/go", kToken), "go");
  for (const char* address :
       {"/cupola/*/go", "/cupola/a-token-of-twenty-?i/go", "/cupola/{a-token-of-twenty-si}/go", "/*/*/*",
        "/cupola/a-token-of-twenty-s[a-z]/go", "/cupola/*", "/cupola/{go}", "/cupola/*go", "/*/go"}) {
    EXPECT_EQ(osc_word(address, kToken), std::nullopt) << address;
  }
  EXPECT_EQ(osc_word("/cupola/a*token{of}[16]/go", "a*token{of}[16]"), "go") << "its signs are its own";
  EXPECT_EQ(osc_word("/cupola/a-token-of-1/go", "a*token{of}[16]"), std::nullopt);
}

}  // namespace
}  // namespace cupola
