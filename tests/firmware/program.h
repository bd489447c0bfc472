// The program as a child of the tests: called, watched, ended.
// SPDX-License-Identifier: MIT
#pragma once

#include <sys/types.h>

#include <chrono>
#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "tests/frame/picture_files.h"

namespace cupola {

struct Outcome {
  int code = -1;    // the exit code; 128 + N when signal N ended it
  std::string out;  // standard output
  std::string err;  // standard error
};

struct Circumstances {
  std::function<void()> in_child = [] {};               // just before the program starts
  std::function<void(pid_t)> meanwhile = [](pid_t) {};  // once it runs
  std::vector<std::string> environment = {};            // NAME=VALUE beside the tests' own
  bool read_output = true;                              // false: the pipe's reader goes away at once
};

Outcome call(const std::vector<std::string>& arguments, const Circumstances& circumstances = {});

// A folder with a small rig, "rig.toml" (96 x 70 pixels; front, left, right and top), and a picture for each
// of its views, "front.png" and so on, 48 x 48 texels.
class ProgramTest : public testing::Test {
 protected:
  ProgramTest();

  std::string path(std::string_view name) const { return (folder_ / name).string(); }
  void write_rig(std::string_view name, std::string_view replaced, std::string_view replacement) const;
  // --rig, --view for each view, --out, and what else is given.
  std::vector<std::string> warp_arguments(std::vector<std::string> more = {}) const;
  // Exit code, every one of `words` on standard error in one line, and no file more or less in the folder.
  void expect_refusal(const std::vector<std::string>& arguments, int code,
                      const std::vector<std::string>& words, const Circumstances& circumstances = {}) const;

  TemporaryFolder folder_;
};

}  // namespace cupola
