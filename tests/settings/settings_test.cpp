// Settings files: what is read, what is refused and in which words.
// SPDX-License-Identifier: MIT
#include "pipeline/settings/settings.h"

#include <filesystem>
#include <fstream>
#include <functional>

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <unistd.h>

#include "pipeline/frame/error.h"

namespace cupola {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::StartsWith;

constexpr std::string_view kModels[] = {"equidistant", "polynomial"};

class Settings : public testing::Test {
 protected:
  Settings() { std::filesystem::create_directory(folder_); }
  ~Settings() override { std::filesystem::remove_all(folder_); }

  void write(std::string_view text) { std::ofstream(file_, std::ios::binary) << text; }
  SettingsTable load(std::string_view text, const std::vector<std::string>& overrides = {}) {
    write(text);
    return load_settings(file_, overrides);
  }
  // The message of what `read` throws, the path of the file shortened to "x.toml".
  std::string refusal(const std::function<void()>& read) const {
    try {
      read();
    } catch (const InputError& error) {
      std::string message = error.what();
      const std::string path = file_.string();
      for (std::size_t at = message.find(path); at != std::string::npos; at = message.find(path)) {
        message.replace(at, path.size(), "x.toml");
      }
      return message;
    }
    return "nothing refused";
  }

  std::filesystem::path folder_ =
      std::filesystem::temp_directory_path() / ("cupola-settings-" + std::to_string(getpid()));
  std::filesystem::path file_ = folder_ / "x.toml";
};

TEST_F(Settings, AreReadByNameAndKind) {
  SettingsTable root = load(R"(
views = "axis"
[frame]
width = 1966
radius = 983
tilt = -1.5
center = [983, 983.5]
flip = true
[[view]]
name = "front"
[[view]]
name = "left"
)");
  EXPECT_EQ(root.text("views"), "axis");
  SettingsTable frame = root.table("frame");
  EXPECT_EQ(frame.integer("width", 1, 65535), 1966);
  EXPECT_EQ(frame.number("radius", 1, 65535), 983.0);
  EXPECT_EQ(frame.number("tilt", -90, 90), -1.5);
  EXPECT_THAT(frame.numbers("center", 2, 2), ElementsAre(983.0, 983.5));
  EXPECT_TRUE(frame.flag("flip"));
  frame.finish();
  std::vector<std::string> names;
  for (SettingsTable& view : root.tables("view")) {
    names.push_back(view.text("name"));
    view.finish();
  }
  EXPECT_THAT(names, ElementsAre("front", "left"));
  root.finish();
}

TEST_F(Settings, FallBackOnlyWhenTheKeyIsMissing) {
  SettingsTable root = load("a = 3\n");
  EXPECT_EQ(root.integer("a", 0, 9, 5), 3);
  EXPECT_EQ(root.integer("b", 0, 9, 5), 5);
  EXPECT_EQ(root.number("c", 0, 9, 2.5), 2.5);
  EXPECT_FALSE(root.flag("d", false));
  EXPECT_EQ(root.text("e", "word"), "word");
  EXPECT_EQ(root.choice("f", kModels, 1), 1U);
  EXPECT_TRUE(root.tables("view").empty());
  SettingsTable missing = root.table("filter");
  EXPECT_FALSE(missing.has("alpha"));
  EXPECT_EQ(missing.number("alpha", 0, 9, 2.0), 2.0);
  missing.finish();
  root.finish();
}

TEST_F(Settings, RefuseNumbersThatAreNoneWithFileLineAndKey) {
  SettingsTable root = load("\n[frame]\nradius = nan\nwidth = inf\nheight = 0\ntop = 7.5\nleft = \"9\"\n");
  SettingsTable frame = root.table("frame");
  EXPECT_EQ(refusal([&] { frame.number("radius", 1, 65535); }),
            "x.toml:3: frame.radius: expected a number from 1 to 65535, not nan");
  EXPECT_EQ(refusal([&] { frame.number("width", 1, 65535); }),
            "x.toml:4: frame.width: expected a number from 1 to 65535, not inf");
  EXPECT_EQ(refusal([&] { frame.integer("height", 1, 65535); }),
            "x.toml:5: frame.height: expected a whole number from 1 to 65535, not 0");
  EXPECT_EQ(refusal([&] { frame.integer("top", 1, 65535); }),
            "x.toml:6: frame.top: expected a whole number from 1 to 65535, not 7.5");
  EXPECT_EQ(refusal([&] { frame.number("left", 0.5, 1e6); }),
            "x.toml:7: frame.left: expected a number from 0.5 to 1e+06, not \"9\"");
}

TEST_F(Settings, RefuseOtherKindsByName) {
  SettingsTable root = load("a = 1\nb = [1, nan]\nc = 1979-05-27\nd = {e = 1}\nf = ['x', 2]\n[[g]]\n");
  EXPECT_EQ(refusal([&] { root.text("a"); }), "x.toml:1: a: expected a text in quotes, not 1");
  EXPECT_EQ(refusal([&] { root.flag("a"); }), "x.toml:1: a: expected true or false, not 1");
  EXPECT_EQ(refusal([&] { root.numbers("a", 2, 2); }), "x.toml:1: a: expected a list of 2 numbers, not 1");
  EXPECT_EQ(refusal([&] { root.numbers("b", 2, 2); }),
            "x.toml:2: b: expected finite numbers, not nan at place 1");
  EXPECT_EQ(refusal([&] { root.numbers("b", 3, 9); }),
            "x.toml:2: b: expected a list of 3 to 9 numbers, not of 2");
  EXPECT_EQ(refusal([&] { root.number("c", 0, 1); }),
            "x.toml:3: c: expected a number from 0 to 1, not a date or time");
  EXPECT_EQ(refusal([&] { root.integer("d", 0, 1); }),
            "x.toml:4: d: expected a whole number from 0 to 1, not a table");
  EXPECT_EQ(refusal([&] { root.tables("d"); }), "x.toml:4: d: expected tables headed [[d]], not a table");
  EXPECT_EQ(refusal([&] { root.texts("f", 0, 9); }),
            "x.toml:5: f: expected texts in quotes, not 2 at place 1");
  EXPECT_EQ(refusal([&] { root.table("g"); }), "x.toml:6: g: expected the table [g], not [[tables]]");
  EXPECT_EQ(refusal([&] { root.table("a"); }), "x.toml:1: a: expected the table [a], not 1");
}

TEST_F(Settings, RefuseAChoiceWithTheNearestOne) {
  SettingsTable root = load("[lens]\nmodel = \"equidistand\"\nother = \"fish\"\n");
  SettingsTable lens = root.table("lens");
  EXPECT_EQ(refusal([&] { lens.choice("model", kModels); }),
            "x.toml:2: lens.model: expected equidistant or polynomial, not \"equidistand\"; did you mean "
            "equidistant?");
  EXPECT_EQ(refusal([&] { lens.choice("other", kModels); }),
            "x.toml:3: lens.other: expected equidistant or polynomial, not \"fish\"");
}

TEST_F(Settings, RefuseAMissingKeyAtItsTable) {
  SettingsTable root = load("\n\n[frame]\nwidth = 4\n");
  SettingsTable frame = root.table("frame");
  EXPECT_EQ(refusal([&] { frame.integer("height", 1, 9); }),
            "x.toml:3: frame.height: missing; expected a whole number from 1 to 9");
  EXPECT_EQ(refusal([&] { root.text("rig"); }), "x.toml: rig: missing; expected a text in quotes");
}

TEST_F(Settings, RefuseTheFirstUnknownKeyWithTheNearestKnownOne) {
  SettingsTable root = load("a = 1\nlense = 2\nbogus_key = 3\n");
  root.integer("a", 0, 9);
  root.table("lens");
  EXPECT_EQ(refusal([&] { root.finish(); }), "x.toml:2: lense: unknown key; did you mean lens?");
}

TEST_F(Settings, RefuseAnUnknownKeyUnlikeAllOthersWithTheWholeList) {
  SettingsTable root = load("[frame]\nwidth = 1\nzzzzzzzz = 3\n");
  SettingsTable frame = root.table("frame");
  frame.integer("width", 0, 9);
  frame.integer("height", 0, 9, 1);
  EXPECT_EQ(refusal([&] { frame.finish(); }),
            "x.toml:3: frame.zzzzzzzz: unknown key; known are height or width");
}

TEST_F(Settings, RefuseAKeyThatWasLookedForButNeverRead) {
  SettingsTable root = load("alpha = 1\n");
  EXPECT_TRUE(root.has("alpha"));
  EXPECT_EQ(refusal([&] { root.finish(); }), "x.toml:1: alpha: has no meaning here");
}

TEST_F(Settings, NameTheirTablesByPlace) {
  SettingsTable root = load("[[view]]\nname = 'a'\n[[view]]\nname = 3\n");
  std::vector<SettingsTable> views = root.tables("view");
  ASSERT_EQ(views.size(), 2U);
  EXPECT_EQ(refusal([&] { views[1].text("name"); }),
            "x.toml:4: view.1.name: expected a text in quotes, not 3");
  EXPECT_EQ(refusal([&] { views[1].refuse("", "no such pose"); }), "x.toml:3: view.1: no such pose");
  EXPECT_EQ(refusal([&] { root.refuse("", "nothing to do"); }), "x.toml: nothing to do");
}

TEST_F(Settings, RefuseFilesThatAreNoToml) {
  EXPECT_EQ(refusal([&] { load_settings(folder_ / "none.toml"); }),
            (folder_ / "none.toml").string() + ": cannot be opened: No such file or directory");
  EXPECT_EQ(refusal([&] { load_settings(folder_); }),
            folder_.string() + ": is a folder; expected a TOML file");
  EXPECT_THAT(refusal([&] { load("a = 1\nb = \n"); }), StartsWith("x.toml:2: "));
  EXPECT_THAT(refusal([&] { load(std::string_view("\x89PNG\r\n\x1a\n\0\0\0\rIHDR", 16)); }),
              StartsWith("x.toml:1: "));
  EXPECT_THAT(refusal([&] { load(std::string(100'000, '[')); }), StartsWith("x.toml:1: "));
  EXPECT_THAT(refusal([&] { load("a = " + std::string(100'000, '[')); }), StartsWith("x.toml:1: "));
  EXPECT_THAT(refusal([&] { load("a = \"" + std::string(100'000, '\xff')); }), StartsWith("x.toml:1: "));
}

TEST_F(Settings, RefuseKeysGivenTwice) {
  const std::string message = refusal([&] { load("a = 1\nb = 2\na = 3\n"); });
  EXPECT_THAT(message, StartsWith("x.toml:3: "));
  EXPECT_THAT(message, HasSubstr("'a'"));
  EXPECT_THAT(refusal([&] { load("[frame]\n[lens]\n[frame]\n"); }), StartsWith("x.toml:3: "));
}

TEST_F(Settings, RefuseEndlessFiles) {
  EXPECT_EQ(refusal([&] { load_settings("/dev/zero"); }),
            "/dev/zero: expected a TOML file of at most 16 MiB");
}

TEST_F(Settings, TakeOverrides) {
  SettingsTable root =
      load("a = 1\n[frame]\nwidth = 4\nheight = 5\n[[view]]\nname = 'front'\nsize = [1, 2]\n",
           {"a=7", "frame.width=8", "lens.model=equidistant", "lens.file=../my lens.toml",
            "view.0.fov_deg = 95.5", "view.0.size.1=3", "path='quoted'", "center=[1, 2]", "ip=1.2.3"});
  EXPECT_EQ(root.integer("a", 0, 9), 7);
  SettingsTable frame = root.table("frame");
  EXPECT_EQ(frame.integer("width", 0, 9), 8);
  EXPECT_EQ(frame.integer("height", 0, 9), 5);
  SettingsTable lens = root.table("lens");
  EXPECT_EQ(lens.text("model"), "equidistant");
  EXPECT_EQ(lens.text("file"), "../my lens.toml");
  std::vector<SettingsTable> views = root.tables("view");
  EXPECT_EQ(views.at(0).number("fov_deg", 0, 180), 95.5);
  EXPECT_THAT(views.at(0).numbers("size", 2, 2), ElementsAre(1, 3));
  EXPECT_EQ(root.text("path"), "quoted");
  EXPECT_EQ(root.text("ip"), "1.2.3");
  EXPECT_THAT(root.numbers("center", 2, 2), ElementsAre(1, 2));
  root.finish();
}

TEST_F(Settings, NameTheOverrideThatIsWrong) {
  const auto with = [&](const std::string& line) { return load("a = 1\n[[view]]\nname = 'x'\n", {line}); };
  EXPECT_EQ(refusal([&] { with("a=nan").number("a", 0, 9); }),
            "--set a=nan: a: expected a number from 0 to 9, not nan");
  EXPECT_EQ(refusal([&] { with("a=").number("a", 0, 9); }).substr(0, 10), "--set a=: ");
  EXPECT_EQ(refusal([&] { with("a"); }), "--set a: expected key=value");
  EXPECT_EQ(refusal([&] { with("=3"); }), "--set =3: expected key=value");
  EXPECT_EQ(refusal([&] { with("a=1\nb=2"); }), "--set a=1\nb=2: expected a single line");
  EXPECT_THAT(refusal([&] { with("a b=2"); }), StartsWith("--set a b=2: "));
  EXPECT_THAT(refusal([&] { with("a=[1"); }), StartsWith("--set a=[1: "));
  EXPECT_EQ(refusal([&] { with("view.1.name=y"); }),
            "--set view.1.name=y: expected a place from 0 to 0, not \"1\"");
  EXPECT_EQ(refusal([&] {
              SettingsTable root = with("lense.model=3");
              root.integer("a", 0, 9);
              root.tables("view");
              root.table("lens");
              root.finish();
            }),
            "--set lense.model=3: lense: unknown key; did you mean lens?");
}

}  // namespace
}  // namespace cupola
