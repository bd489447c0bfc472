// Playing the script, and answering as a driver would.
// SPDX-License-Identifier: MIT
#include "hal/gpio/fake_gpio.h"

#include <algorithm>
#include <cassert>
#include <cerrno>
#include <utility>

#include "hal/gpio/gpio_search.h"

namespace cupola {

using std::chrono::nanoseconds;

namespace {
constexpr std::size_t kMostWrites = 65536;
}

FakeGpio::FakeGpio(FakeClock& clock, std::vector<FakeGpioChip> chips)
    : clock_(clock), alarm_(clock.add_alarm()) {
  for (FakeGpioChip& chip : chips) {
    chips_.push_back({std::move(chip.label), pins_.size(), chip.lines.size()});
    for (std::string& line : chip.lines) pins_.push_back({std::move(line), chips_.size() - 1});
  }
  writes_.reserve(kMostWrites);
}

std::size_t FakeGpio::pin(std::string_view name) const {
  const auto found = std::find_if(pins_.begin(), pins_.end(), [&](const Pin& p) { return p.name == name; });
  assert(found != pins_.end());
  return static_cast<std::size_t>(found - pins_.begin());
}

std::size_t FakeGpio::chip(std::string_view label) const {
  const auto found =
      std::find_if(chips_.begin(), chips_.end(), [&](const Chip& c) { return c.label == label; });
  assert(found != chips_.end());
  return static_cast<std::size_t>(found - chips_.begin());
}

void FakeGpio::add(Step step) {
  const auto later =
      std::upper_bound(script_.begin() + static_cast<std::ptrdiff_t>(next_step_), script_.end(), step.at,
                       [](nanoseconds at, const Step& other) { return at < other.at; });
  script_.insert(later, step);
  step_world();
  set_alarm();
}

void FakeGpio::pull(std::string_view line, bool high, nanoseconds at) {
  add({at, Act::kPull, pin(line), high});
}

void FakeGpio::bounce(std::string_view line, bool high, nanoseconds at, int edges, nanoseconds apart) {
  for (int i = 0; i < edges; ++i) pull(line, high == ((edges - i) % 2 == 1), at + i * apart);
}

void FakeGpio::unplug(std::string_view label, nanoseconds at) {
  add({at, Act::kUnplug, chip(label), false});
}

void FakeGpio::plug(std::string_view label, nanoseconds at) {
  add({at, Act::kPlug, chip(label), false});
}

void FakeGpio::take(std::string_view line, bool taken) {
  pins_[pin(line)].taken = taken;
}

void FakeGpio::refuse(FakeGpioCall call, int error, int times) {
  refusals_[static_cast<std::size_t>(call)] = {error, times};
  set_alarm();
}

bool FakeGpio::fails(FakeGpioCall call, int& error) noexcept {
  Refusal& refusal = refusals_[static_cast<std::size_t>(call)];
  if (refusal.times == 0) return false;
  --refusal.times;
  error = refusal.error;
  return true;
}

bool FakeGpio::high(std::string_view line) {
  step_world();
  return pins_[pin(line)].high;
}

// Everything that has happened by now.
void FakeGpio::step_world() noexcept {
  for (; next_step_ < script_.size() && script_[next_step_].at <= clock_.now(); ++next_step_) {
    const Step& step = script_[next_step_];
    if (step.act != Act::kPull) {
      Chip& chip = chips_[step.target];
      chip.there = step.act == Act::kPlug;
      chip.lost = chip.lost || !chip.there;
      for (const Line& line : lines_) {
        if (!chip.there && line.output && pins_[line.pin].chip == step.target) pins_[line.pin].high = false;
      }
      continue;
    }
    Pin& pulled = pins_[step.target];
    if (pulled.high == step.high) continue;
    pulled.high = step.high;
    if (!working_ || chips_[pulled.chip].lost) continue;
    for (Line& line : lines_) {
      if (line.pin != step.target || line.output) continue;
      Queue& queue = line.queue;
      if (queue.count < queue.events.size()) {
        queue.events[queue.count++] = {step.high != line.active_low, step.at};
      }
    }
  }
}

void FakeGpio::set_alarm() noexcept {
  nanoseconds next = next_step_ < script_.size() ? script_[next_step_].at : nanoseconds::max();
  if (refusals_[static_cast<std::size_t>(FakeGpioCall::kPoll)].times > 0) next = clock_.now();
  for (const Line& line : lines_) {
    if (line.queue.count > 0 || chips_[pins_[line.pin].chip].lost) next = clock_.now();
  }
  clock_.set_alarm(alarm_, next);
}

void FakeGpio::write(const Line& line, bool active) noexcept {
  Pin& written = pins_[line.pin];
  written.high = active != line.active_low;
  if (writes_.size() < kMostWrites) writes_.push_back({written.name, written.high, clock_.now()});
}

std::variant<GpioLevels, GpioTrouble> FakeGpio::start(std::span<const GpioLine> lines) noexcept {
  stop();
  assert(lines.size() <= kMostGpioLines);
  step_world();
  GpioTrouble trouble{GpioCause::kFailed, "request"};
  if (fails(FakeGpioCall::kStart, trouble.error)) return trouble;
  std::vector<GpioChipNames> names;
  std::vector<std::size_t> there;
  for (std::size_t i = 0; i < chips_.size(); ++i) {
    if (!chips_[i].there) continue;
    names.push_back({"", chips_[i].label, chips_[i].pins});
    there.push_back(i);
  }
  const auto offset_of = [&](std::size_t i, const std::string& name) {
    const Chip& chip = chips_[there[i]];
    for (std::size_t offset = 0; offset < chip.pins; ++offset) {
      if (pins_[chip.first_pin + offset].name == name) return static_cast<int>(offset);
    }
    return -1;
  };
  GpioLevels levels;
  std::vector<Line> taken;
  for (std::size_t i = 0; i < lines.size(); ++i) {
    auto found = find_line(lines[i], names, offset_of);
    if (auto* missing = std::get_if<GpioTrouble>(&found)) {
      missing->line = static_cast<int>(i);
      return *missing;
    }
    const FoundLine at = std::get<FoundLine>(found);
    Line line{chips_[there[at.chip]].first_pin + at.offset, lines[i].output, lines[i].active_low, {}};
    const bool twice =
        std::any_of(taken.begin(), taken.end(), [&](const Line& other) { return other.pin == line.pin; });
    if (pins_[line.pin].taken || twice) {
      return GpioTrouble{GpioCause::kBusy, "request", EBUSY, static_cast<int>(i)};
    }
    taken.push_back(line);
  }
  lines_ = std::move(taken);
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    chips_[pins_[line.pin].chip].lost = false;
    if (line.output) {
      write(line, lines[i].active);
    } else {
      levels[i] = line.queue.handed = pins_[line.pin].high != line.active_low;
    }
  }
  working_ = true;
  ++starts_;
  set_alarm();
  return levels;
}

void FakeGpio::stop() noexcept {
  working_ = false;
  lines_.clear();
  set_alarm();
}

GpioPoll FakeGpio::poll(GpioEdge& edge, GpioTrouble& trouble) noexcept {
  if (!working_) return GpioPoll::kNothing;
  step_world();
  trouble = {GpioCause::kGone, "poll", ENODEV};
  if (fails(FakeGpioCall::kPoll, trouble.error)) return GpioPoll::kLost;
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    Line& line = lines_[i];
    Queue& queue = line.queue;
    if (chips_[pins_[line.pin].chip].lost) {
      trouble.line = static_cast<int>(i);
      return GpioPoll::kLost;
    }
    const bool now = pins_[line.pin].high != line.active_low;
    if (queue.count > 0) {
      edge = {i, queue.events[0].active, queue.events[0].at};
      std::move(queue.events.begin() + 1, queue.events.begin() + static_cast<std::ptrdiff_t>(queue.count),
                queue.events.begin());
      --queue.count;
      queue.unchecked = true;
    } else if (std::exchange(queue.unchecked, false) && now != queue.handed) {
      edge = {i, now, clock_.now()};
    } else {
      continue;
    }
    queue.handed = edge.active;
    set_alarm();
    return GpioPoll::kEdge;
  }
  set_alarm();
  return GpioPoll::kNothing;
}

std::optional<GpioTrouble> FakeGpio::set(std::size_t index, bool active) noexcept {
  GpioTrouble trouble{GpioCause::kFailed, "set value", 0, static_cast<int>(index)};
  if (fails(FakeGpioCall::kSet, trouble.error)) return trouble;
  step_world();
  if (!working_ || chips_[pins_[lines_[index].pin].chip].lost) {
    return GpioTrouble{GpioCause::kGone, "set value", ENODEV, static_cast<int>(index)};
  }
  write(lines_[index], active);
  return std::nullopt;
}

}  // namespace cupola
