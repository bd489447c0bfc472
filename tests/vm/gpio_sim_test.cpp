// The kernel's GPIO character devices keep what all lines promise: gpio-sim's, driven by their sysfs files.
// SPDX-License-Identifier: MIT
#include <algorithm>
#include <chrono>
#include <filesystem>
#include <fstream>
#include <stdexcept>
#include <thread>

#include "hal/gpio/gpiod_lines.h"
#include "tests/hal/gpio_contract.h"

namespace cupola {
namespace {

namespace fs = std::filesystem;

void put(const fs::path& file, const std::string& text) {
  std::ofstream stream(file);
  stream << text << '\n' << std::flush;
  if (!stream) throw std::runtime_error(file.string() + ": cannot be written");
}

std::string get(const fs::path& file) {
  std::ifstream stream(file);
  std::string text;
  std::getline(stream, text);
  return text;
}

// A chip with named lines, from configfs, for as long as the object lives.
class SimChip {
 public:
  SimChip(const std::string& label, const std::vector<std::string>& lines, const std::string& hogged = "")
      : folder_(fs::path("/sys/kernel/config/gpio-sim") / label), lines_(lines) {
    fs::create_directory(folder_);
    fs::create_directory(bank());
    put(bank() / "num_lines", std::to_string(lines.size()));
    put(bank() / "label", label);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      fs::create_directory(line(i));
      put(line(i) / "name", lines[i]);
      if (lines[i] != hogged) continue;
      fs::create_directory(line(i) / "hog");
      put(line(i) / "hog" / "name", "other-driver");
      put(line(i) / "hog" / "direction", "output-high");
    }
    set_live(true);
  }
  ~SimChip() {
    if (get(folder_ / "live") == "1") put(folder_ / "live", "0");
    std::error_code ignored;  // configfs: only rmdir, from within
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      fs::remove(line(i) / "hog", ignored);
      fs::remove(line(i), ignored);
    }
    fs::remove(bank(), ignored);
    fs::remove(folder_, ignored);
  }
  SimChip(const SimChip&) = delete;
  SimChip& operator=(const SimChip&) = delete;

  void set_live(bool live) const { put(folder_ / "live", live ? "1" : "0"); }
  bool has(const std::string& name) const { return offset(name) < lines_.size(); }
  void pull(const std::string& name, bool high) const {
    put(pin(name) / "pull", high ? "pull-up" : "pull-down");
  }
  bool high(const std::string& name) const { return get(pin(name) / "value") == "1"; }

 private:
  fs::path bank() const { return folder_ / "bank"; }
  fs::path line(std::size_t offset) const { return bank() / ("line" + std::to_string(offset)); }
  std::size_t offset(const std::string& name) const {
    return static_cast<std::size_t>(std::find(lines_.begin(), lines_.end(), name) - lines_.begin());
  }
  fs::path pin(const std::string& name) const {
    return fs::path("/sys/devices/platform") / get(folder_ / "dev_name") / get(bank() / "chip_name") /
           ("sim_gpio" + std::to_string(offset(name)));
  }

  fs::path folder_;
  std::vector<std::string> lines_;
};

class SimBench final : public GpioBench {
 public:
  Clock& clock() override { return clock_; }
  Gpio& gpio() override { return *gpio_; }
  void pull(const std::string& line, bool high) override {
    chip(line).pull(line, high);
    std::this_thread::sleep_for(4ms);  // edges that follow at once would merge with this one
  }
  void storm(const std::string& line, int edges) override {
    const bool high = chip(line).high(line);
    for (int i = 0; i < edges; ++i) chip(line).pull(line, (i % 2 == 0) != high);
  }
  bool high(const std::string& line) override { return chip(line).high(line); }
  void unplug() override { panel_.set_live(false); }
  void plug() override { panel_.set_live(true); }

 private:
  const SimChip& chip(const std::string& line) const { return panel_.has(line) ? panel_ : stage_; }

  SimChip panel_{"panel", {"play", "next", "blackout", "lamp", "shutter", "taken"}, "taken"};
  SimChip stage_{"stage", {"sensor", "tally"}};
  MonotonicClock clock_;
  std::unique_ptr<Gpio> gpio_ = make_gpiod_lines(clock_);
};

INSTANTIATE_TEST_SUITE_P(GpioSim, GpioContract,
                         testing::Values(GpioBenchMaker{
                             "Lines",
                             [] { return std::unique_ptr<GpioBench>(std::make_unique<SimBench>()); }}),
                         [](const auto& maker) { return std::string(maker.param.name); });

[[maybe_unused]] const auto* const kCount = testing::AddGlobalTestEnvironment(new EdgeCount("gpio-sim"));

}  // namespace
}  // namespace cupola
