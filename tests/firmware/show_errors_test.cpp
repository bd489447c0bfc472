// A show's and its rig's errors are found all at once, each with its line, none following from another.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>
#include <fmt/ranges.h>
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <random>
#include <set>

#include "firmware/show.h"
#include "pipeline/frame/error.h"
#include "tests/frame/temporary_folder.h"

namespace cupola {
namespace {

using testing::ElementsAre;

constexpr const char* kRig = R"(views = "axis"
tilt_deg = 11.0
[frame]
width = 960
height = 700
center = [480.0, 480.0]
radius = 480.0
crop = "none"
[lens]
model = "polynomial"
coefficients = [0, 1.4, -0.1]
[filter]
kernel = "gaussian"
alpha = 5.0
radius = 1.0
rec = 0.5
light = "encoded"
dither = true
[[view]]
name = "front"
size = [64, 64]
fov_deg = 90
[[view]]
name = "beside"
forward = [-1, 0, 0]
up = [0, 1, 0]
[[camera]]
view = "front"
driver = "fake"
device = "one"
size = [64, 64]
rate = 30
buffers = 4
patience_ms = 300
[sync]
tolerance_ms = 5
[gpio]
[[gpio.input]]
chip = "a"
offset = 3
does = "go"
bias = "pull-up"
[[gpio.output]]
name = "lamp"
is = "tally"
active_low = true
[display]
connector = "HDMI-A-1"
mode = "1920x1200@60"
)";

constexpr const char* kShow = R"(rig = "rig.toml"
[control]
http = "127.0.0.1:8080"
[machine]
priority = 20
cores = [0, 1]
lock_memory = true
[[cue]]
name = "pattern"
source = "test-pattern"
world = "grid"
face_size = [64, 64]
duration_s = 10
transition = "fade"
fade_s = 1.5
[[cue]]
name = "frames"
source = "sequence"
file = "{view}_%06d.png"
rate = 30
in = 5
out = 80
loop = true
then = "pattern"
[[cue]]
name = "film"
source = "video"
file = "film.mp4"
layout = "3x2"
padding = 4
then = "wait"
)";

std::vector<std::string> lines_of(const std::string& text) {
  std::vector<std::string> lines;
  for (std::size_t at = 0; at < text.size();) {
    const std::size_t end = text.find('\n', at);
    lines.push_back(text.substr(at, end - at));
    at = end + 1;
  }
  return lines;
}

std::string key_of(const std::string& line) {
  const std::size_t equals = line.find(" = ");
  return equals == std::string::npos ? "" : line.substr(0, equals);
}

// One way to be wrong: the line that is put for another one, or after it.
struct Mistake {
  bool show = true;  // or the rig
  std::size_t line = 0;
  std::string text;
  bool after = false;
  std::string word;  // of the message
};

// What no key of its name can be.
std::string wrong_value(const std::string& key) {
  static const std::set<std::string> kWords = {"views",  "crop",  "model",  "kernel", "light",
                                               "driver", "does",  "bias",   "is",     "mode",
                                               "source", "world", "layout", "http",   "transition"};
  static const std::set<std::string> kNumbers = {
      "tilt_deg",    "radius",       "alpha",      "rec",    "fov_deg", "rate",
      "patience_ms", "tolerance_ms", "duration_s", "fade_s", "in",      "out",
      "padding",     "priority",     "buffers",    "offset", "width",   "height"};
  if (kWords.contains(key)) return "\"quux\"";
  if (kNumbers.contains(key)) return "-1000000";
  return "";
}

std::vector<Mistake> all_mistakes(bool show, const std::vector<std::string>& lines) {
  std::vector<Mistake> mistakes;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const std::string key = key_of(lines[i]);
    mistakes.push_back({show, i, "zzqqxxyy = 1", true, "zzqqxxyy"});
    if (lines[i] == "[gpio]") mistakes.pop_back();  // would be two of one line's
    if (key.empty()) continue;
    if (key != "rig") mistakes.push_back({show, i, key + " = 1979-05-27", false, key});
    const std::string wrong = wrong_value(key);
    if (!wrong.empty()) mistakes.push_back({show, i, key + " = " + wrong, false, key});
  }
  return mistakes;
}

class ShowErrors : public testing::Test {
 protected:
  std::vector<std::string> errors_of(const std::string& rig, const std::string& show) {
    write("rig.toml", rig);
    write("show.toml", show);
    SettingsErrors errors;
    load_show(folder_ / "show.toml", {}, {}, &errors);
    std::vector<std::string> lines = errors.lines();
    const std::string place = (folder_ / "").string();
    for (std::string& line : lines) {
      for (std::size_t at = line.find(place); at != std::string::npos; at = line.find(place))
        line.erase(at, place.size());
    }
    return lines;
  }
  void write(const char* name, const std::string& text) {
    std::ofstream(folder_ / name, std::ios::binary) << text;
  }
  TemporaryFolder folder_;
};

TEST_F(ShowErrors, AreNoneInAShowThatIsRight) {
  EXPECT_THAT(errors_of(kRig, kShow), ElementsAre());
}

TEST_F(ShowErrors, AreAllReportedWithTheirLinesAndNoneBesides) {
  const std::vector<std::string> rig = lines_of(kRig);
  const std::vector<std::string> show = lines_of(kShow);
  std::vector<Mistake> pool = all_mistakes(false, rig);
  const std::vector<Mistake> more = all_mistakes(true, show);
  pool.insert(pool.end(), more.begin(), more.end());
  std::mt19937 random(7);
  for (int round = 0; round < 400; ++round) {
    std::shuffle(pool.begin(), pool.end(), random);
    std::set<std::pair<bool, std::size_t>> taken;
    std::set<std::pair<bool, std::size_t>> tables;  // with a stranger: a key cannot be there twice
    std::vector<Mistake> chosen;
    const std::size_t most = 1 + random() % 12;
    for (const Mistake& mistake : pool) {
      if (chosen.size() == most) break;
      if (!taken.insert({mistake.show, mistake.line}).second) continue;
      if (mistake.after) {
        const std::vector<std::string>& lines = mistake.show ? show : rig;
        std::size_t header = mistake.line;
        while (header > 0 && lines[header].front() != '[') --header;
        if (!tables.insert({mistake.show, header}).second) continue;
      }
      chosen.push_back(mistake);
    }
    std::set<std::string> expected;  // "file:line: ... word"
    std::string texts[2];
    for (const bool of_show : {false, true}) {
      const std::vector<std::string>& lines = of_show ? show : rig;
      std::size_t number = 0;
      for (std::size_t i = 0; i < lines.size(); ++i) {
        const auto at = std::find_if(chosen.begin(), chosen.end(), [&](const Mistake& mistake) {
          return mistake.show == of_show && mistake.line == i;
        });
        const bool found = at != chosen.end();
        texts[of_show] += (found && !at->after ? at->text : lines[i]) + "\n";
        ++number;
        if (found && at->after) {
          texts[of_show] += at->text + "\n";
          ++number;
        }
        if (found)
          expected.insert(fmt::format("{}:{} {}", of_show ? "show.toml" : "rig.toml", number, at->word));
      }
    }
    std::set<std::string> said;
    const std::vector<std::string> errors = errors_of(texts[0], texts[1]);
    for (const std::string& error : errors) {
      const std::size_t place = error.find(": ");
      const std::string key = error.substr(place + 2, error.find(": ", place + 2) - place - 2);
      said.insert(error.substr(0, place) + " " + key.substr(key.rfind('.') + 1));
    }
    ASSERT_EQ(said, expected) << fmt::format("{}", fmt::join(errors, "\n")) << "\n" << texts[0] << texts[1];
    ASSERT_EQ(errors.size(), chosen.size()) << fmt::format("{}", fmt::join(errors, "\n"));
  }
}

TEST_F(ShowErrors, OfMissingKeysAreAtTheirTables) {
  EXPECT_THAT(
      errors_of("[frame]\nheight = 3\nextra = 1\n[[view]]\nfov_deg = 200\n",
                "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nrate = 0\n"),
      ElementsAre("show.toml:2: cue.0.source: missing; expected stills, sequence, atlas, video, generated, "
                  "test-pattern or live",
                  "show.toml:4: cue.0.rate: expected a number from 0.01 to 1000, not 0",
                  "rig.toml: lens: expected a table [lens] with a model",
                  "rig.toml:1: frame.width: missing; expected a whole number from 1 to 65535",
                  "rig.toml:3: frame.extra: unknown key; known are center, crop, height, model, radius "
                  "or width",
                  "rig.toml:4: view.0.name: missing; expected a text in quotes",
                  "rig.toml:5: view.0.fov_deg: expected a number from 0.1 to 179, not 200"));
}

TEST_F(ShowErrors, OfLiveCuesAreTheKeysOfOtherSources) {
  const std::string show =
      "rig = \"rig.toml\"\n[[cue]]\nname = \"a\"\nsource = \"live\"\ncompare = \"nearest\"\nrate = 60\n"
      "[[cue]]\nname = \"b\"\nsource = \"live\"\nsound = \"own\"\n";
  EXPECT_THAT(errors_of(kRig, show),
              ElementsAre("show.toml:5: cue.0.compare: expected none where the source is live",
                          testing::StartsWith("show.toml:6: cue.0.rate: unknown key"),
                          "show.toml:10: cue.1.sound: expected a file: only a video has a sound of its own"));
}

TEST_F(ShowErrors, AMisspeltKeyIsNotAMissingOneToo) {
  std::string rig = kRig;
  rig.replace(rig.find("width"), 5, "widht");
  std::string show = kShow;
  show.replace(show.find("source"), 6, "sorce");
  EXPECT_THAT(errors_of(rig, show),
              ElementsAre("show.toml:10: cue.0.sorce: unknown key; did you mean source?",
                          "rig.toml:4: frame.widht: unknown key; did you mean width?"));
}

TEST_F(ShowErrors, SayTheNearestNames) {
  std::string rig = kRig;
  rig.replace(rig.find("view = \"front\""), 14, "view = \"fornt\"");
  std::string show = kShow;
  show.replace(show.find("then = \"pattern\""), 16, "then = \"patern\"");
  EXPECT_THAT(
      errors_of(rig, show),
      ElementsAre("show.toml:24: cue.1.then: expected next, wait, stop or the name of a cue, not \"patern\"; "
                  "did you mean pattern?",
                  "rig.toml:28: camera.0.view: expected the name of one of this rig's views, not \"fornt\"; "
                  "did you mean front?"));
}

TEST_F(ShowErrors, OfARigThatIsNoTomlAreNotTheShowsEnd) {
  const std::vector<std::string> errors =
      errors_of("[frame\n", "rig = \"rig.toml\"\nbogus = 1\n[[cue]]\nname = 3\n");
  ASSERT_EQ(errors.size(), 4U) << fmt::format("{}", fmt::join(errors, "\n"));
  EXPECT_THAT(errors[0], testing::StartsWith("rig.toml:1: "));
}

TEST_F(ShowErrors, AreThrownOneByOneWhereNobodyGathers) {
  write("rig.toml", kRig);
  write("show.toml", std::string(kShow) + "bogus = 1\nloop = 3\n");
  try {
    load_show(folder_ / "show.toml", {});
    FAIL();
  } catch (const InputError& error) {
    EXPECT_THAT(error.what(), testing::EndsWith("show.toml:33: cue.2.loop: expected true or false, not 3"));
  }
}

}  // namespace
}  // namespace cupola
