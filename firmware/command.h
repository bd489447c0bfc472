// What the program's commands have in common.
// SPDX-License-Identifier: MIT
#pragma once

#include <CLI/CLI.hpp>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/frame/image.h"
#include "pipeline/frame/still.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

// Made before the command line is read, to say what there is to give; run when it was the one chosen.
class Command {
 public:
  Command(CLI::App& program, const std::string& name, const std::string& description,
          const std::string& examples);
  virtual ~Command() = default;
  Command(const Command&) = delete;
  Command& operator=(const Command&) = delete;

  bool chosen() const { return options_->parsed(); }
  // Throws InputError or Failure. Returns the exit code.
  virtual int run() = 0;

 protected:
  CLI::App& options() { return *options_; }
  // An option that may be given several times, with one value each.
  CLI::Option* repeatable(const std::string& name, std::vector<std::string>& values,
                          const std::string& description);
  int threads() const { return threads_; }  // 0: one a core
  Cpu cpu() const;                          // throws InputError when the machine lacks it
  // For commands that use tables: --no-cache, the cache that it and the environment leave, and the one line
  // on standard error when that could not keep a table.
  void offer_cache();
  TableCache cache() const;
  static void warn_about(const TableCache& cache);
  const std::vector<std::string>& overrides() const { return overrides_; }

 private:
  CLI::App* options_;
  int threads_ = 0;
  std::string cpu_;
  bool no_cache_ = false;
  std::vector<std::string> overrides_;
};

std::unique_ptr<Command> make_warp_command(CLI::App& program);
std::unique_ptr<Command> make_render_command(CLI::App& program);
std::unique_ptr<Command> make_play_command(CLI::App& program);
std::unique_ptr<Command> make_table_command(CLI::App& program);
std::unique_ptr<Command> make_check_command(CLI::App& program);
std::unique_ptr<Command> make_calibrate_command(CLI::App& program);
std::unique_ptr<Command> make_devices_command(CLI::App& program);
std::unique_ptr<Command> make_status_command(CLI::App& program);
std::unique_ptr<Command> make_bench_command(CLI::App& program);

// 1234567 as "1,234,567".
std::string grouped(std::int64_t number);
// Whether a name for what comes out means a Y4M video: FILE.y4m, or - for standard output.
bool is_video_name(const std::string& path);
// Refuses - where standard output is a terminal.
void expect_pipe(const std::string& path);
// Refuses names of kinds of file that are not written.
void expect_png_name(const std::string& path);
StillFormat format_by_name(const std::string& path);  // EXR by its ending; else PNG

}  // namespace cupola
