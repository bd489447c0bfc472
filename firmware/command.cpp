// Options that every command takes.
// SPDX-License-Identifier: MIT
#include "firmware/command.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <unistd.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>

#include "pipeline/frame/error.h"

namespace cupola {

Command::Command(CLI::App& program, const std::string& name, const std::string& description,
                 const std::string& examples)
    : options_(program.add_subcommand(name, description)) {
  options_->footer("Examples:\n" + examples);
  options_->add_option("--threads", threads_, "Threads to work with; one a core unless given")
      ->check(CLI::Range(1, 256))
      ->type_name("N");
  options_
      ->add_option(
          "--cpu", cpu_,
          fmt::format("Instruction set: {}; the fastest there is unless given", fmt::join(kCpuNames, ", ")))
      ->type_name("NAME");
  repeatable("--set", overrides_, "Lay a value over the config file, as in --set frame.width=1024")
      ->type_name("KEY=VALUE");
}

CLI::Option* Command::repeatable(const std::string& name, std::vector<std::string>& values,
                                 const std::string& description) {
  return options_->add_option(name, values, description)->allow_extra_args(false)->type_name("TEXT");
}

void Command::offer_cache() {
  options_->add_flag(
      "--no-cache", no_cache_,
      "Build the warp's table, without looking for it or keeping it; CUPOLA_CACHE=off does the "
      "same, CUPOLA_CACHE=DIR keeps tables there instead of in ~/.cache/cupola");
}

TableCache Command::cache() const {
  return no_cache_ ? TableCache() : TableCache(cache_folder());
}

void Command::warn_about(const TableCache& cache) {
  if (!cache.trouble().empty()) fmt::print(stderr, "cupola: the table is not kept: {}\n", cache.trouble());
}

Cpu Command::cpu() const {
  if (cpu_.empty()) return best_cpu();
  const auto* const found = std::find(std::begin(kCpuNames), std::end(kCpuNames), cpu_);
  if (found == std::end(kCpuNames)) {
    throw InputError(fmt::format("--cpu {}: expected {}", cpu_, fmt::join(kCpuNames, ", ")));
  }
  const Cpu cpu = static_cast<Cpu>(found - std::begin(kCpuNames));
  if (!supported(cpu)) throw InputError(fmt::format("--cpu {}: this machine does not have it", cpu_));
  return cpu;
}

std::string grouped(std::int64_t number) {
  std::string digits = fmt::format("{}", number);
  for (std::ptrdiff_t i = static_cast<std::ptrdiff_t>(digits.size()) - 3; i > (number < 0 ? 1 : 0); i -= 3) {
    digits.insert(static_cast<std::size_t>(i), ",");
  }
  return digits;
}

bool is_video_name(const std::string& path) {
  return path == "-" || std::filesystem::path(path).extension() == ".y4m";
}

void expect_pipe(const std::string& path) {
  if (path == "-" && isatty(STDOUT_FILENO) == 1) {
    throw InputError("--out -: expected a pipe or a file as standard output");
  }
}

static std::string lower_ending(const std::string& path) {
  std::string ending = std::filesystem::path(path).extension().string();
  std::transform(ending.begin(), ending.end(), ending.begin(),
                 [](unsigned char c) { return std::tolower(c); });
  return ending;
}

StillFormat format_by_name(const std::string& path) {
  if (lower_ending(path) == ".exr") return StillFormat::kExr;
  expect_png_name(path);
  return StillFormat::kPng;
}

void expect_png_name(const std::string& path) {
  const std::string ending = lower_ending(path);
  for (const std::string_view other : {".jpg", ".jpeg", ".tif", ".tiff", ".exr", ".bmp", ".ppm", ".webp"}) {
    if (ending == other)
      throw InputError(path + ": expected a name that ends in .png: pictures are written as PNG");
  }
}

}  // namespace cupola
