// Debouncing, and beginning again.
// SPDX-License-Identifier: MIT
#include "hal/gpio/gpio_watch.h"

#include <algorithm>
#include <cassert>
#include <utility>

namespace cupola {

using std::chrono::nanoseconds;
using namespace std::chrono_literals;

namespace {

constexpr nanoseconds kRetry = 100ms;
constexpr int kMostEdges = 1024;  // taken from the driver in one poll: a humming input must not hold the loop

bool wanted(GpioEdges edges, bool active) {
  return edges == GpioEdges::kBoth || (edges == GpioEdges::kToActive) == active;
}

}  // namespace

GpioWatch::GpioWatch(Gpio& gpio, std::vector<GpioLine> lines, Clock& clock)
    : gpio_(gpio), lines_(std::move(lines)), clock_(clock), next_start_(clock.now()) {
  assert(lines_.size() <= kMostGpioLines);
  for (const GpioLine& line : lines_) debouncers_.emplace_back(line.debounce, line.debounce_kind);
}

GpioWatch::~GpioWatch() {
  gpio_.stop();
}

bool GpioWatch::start() noexcept {
  const auto started = gpio_.start(lines_);
  if (const auto* trouble = std::get_if<GpioTrouble>(&started)) {
    trouble_ = *trouble;
    ++counts_.failed_starts;
    next_start_ = clock_.now() + kRetry;
    return false;
  }
  const GpioLevels& levels = std::get<GpioLevels>(started);
  for (std::size_t i = 0; i < lines_.size(); ++i) debouncers_[i].reset(levels[i]);
  waiting_.reset();
  state_ = GpioState::kWorking;
  return true;
}

void GpioWatch::lose(const GpioTrouble& trouble) noexcept {
  gpio_.stop();
  trouble_ = trouble;
  ++counts_.losses;
  state_ = GpioState::kLost;
  to_say_lost_ = true;
  next_start_ = clock_.now() + kRetry;
}

bool GpioWatch::hand_on(std::size_t line, nanoseconds now, GpioEdge& edge) noexcept {
  while (const std::optional<Debouncer::Change> change = debouncers_[line].change(now)) {
    if (!wanted(lines_[line].edges, change->active)) continue;
    edge = {line, change->active, change->at};
    ++counts_.edges;
    return true;
  }
  return false;
}

GpioWatch::Poll GpioWatch::poll(GpioEdge& edge) noexcept {
  const nanoseconds now = last_poll_ = clock_.now();
  if (std::exchange(to_say_lost_, false)) {
    said_lost_ = true;
    return Poll::kLost;
  }
  if (state_ == GpioState::kLost) {
    if (now < next_start_) return Poll::kNothing;
    if (!start()) return std::exchange(said_lost_, true) ? Poll::kNothing : Poll::kLost;
    const bool lost = std::exchange(said_lost_, false);
    if (lost && started_) ++counts_.returns;
    started_ = true;
    if (lost) return Poll::kBack;
  }
  for (int taken = 0; taken < kMostEdges; ++taken) {
    if (!waiting_) {
      GpioEdge raw;
      GpioTrouble trouble;
      const GpioPoll polled = gpio_.poll(raw, trouble);
      if (polled == GpioPoll::kLost) {
        lose(trouble);
        return poll(edge);
      }
      if (polled == GpioPoll::kNothing) break;
      ++counts_.raw_edges;
      waiting_ = raw;
    }
    if (hand_on(waiting_->line, waiting_->at, edge)) return Poll::kEdge;
    debouncers_[waiting_->line].edge(waiting_->active, waiting_->at);
    const GpioEdge taken_edge = *std::exchange(waiting_, std::nullopt);
    if (hand_on(taken_edge.line, taken_edge.at, edge)) return Poll::kEdge;
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (hand_on(i, now, edge)) return Poll::kEdge;
  }
  return Poll::kNothing;
}

void GpioWatch::set(std::size_t line, bool active) noexcept {
  assert(lines_[line].output);
  if (std::exchange(lines_[line].active, active) == active || state_ == GpioState::kLost) return;
  if (const std::optional<GpioTrouble> trouble = gpio_.set(line, active)) lose(*trouble);
}

bool GpioWatch::active(std::size_t line) const noexcept {
  return lines_[line].output ? lines_[line].active : debouncers_[line].active();
}

nanoseconds GpioWatch::deadline() const noexcept {
  if (to_say_lost_) return last_poll_;
  if (state_ == GpioState::kLost) return next_start_;
  nanoseconds first = last_poll_ + kRetry;  // to see a chip go
  for (const Debouncer& debouncer : debouncers_) first = std::min(first, debouncer.deadline());
  return first;
}

}  // namespace cupola
