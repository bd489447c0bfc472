// What the operator's lines mean.
// SPDX-License-Identifier: MIT
#include "firmware/control_panel.h"

#include <cstdio>

namespace cupola {
namespace {

constexpr int kMostEdges = 64;  // acted upon before a frame

std::vector<GpioLine> lines_of(const GpioSettings& settings) {
  std::vector<GpioLine> lines;
  for (const PanelInput& input : settings.inputs) lines.push_back(input.line);
  for (const PanelOutput& output : settings.outputs) {
    lines.push_back(output.line);
    lines.back().active = output.is == OutputIs::kShutter;
  }
  return lines;
}

}  // namespace

ControlPanel::ControlPanel(const GpioSettings& settings, Gpio& gpio, Clock& clock)
    : watch_(gpio, lines_of(settings), clock) {
  for (const PanelInput& input : settings.inputs) inputs_.push_back(input.does);
  for (const PanelOutput& output : settings.outputs) outputs_.push_back(output.is);
  poll();
}

void ControlPanel::press(std::size_t input, bool active, Wishes& wishes) noexcept {
  switch (inputs_[input]) {
    case InputDoes::kPlayPause:
      held_ = held_ != active;
      break;
    case InputDoes::kNext:
      wishes.next += active ? 1 : 0;
      break;
    case InputDoes::kBlackout:
      wishes.blackout = wishes.blackout || active;  // even if it was let go before the frame
      break;
  }
}

ControlPanel::Wishes ControlPanel::poll() noexcept {
  Wishes wishes;
  GpioEdge edge;
  for (int i = 0; i < kMostEdges; ++i) {
    const GpioWatch::Poll said = watch_.poll(edge);
    if (said == GpioWatch::Poll::kNothing) break;
    if (said == GpioWatch::Poll::kEdge) press(edge.line, edge.active, wishes);
    if (said == GpioWatch::Poll::kLost) {
      std::fprintf(stderr, "cupola: gpio: %s\n", describe(watch_.trouble(), watch_.lines()).c_str());
    }
    if (said == GpioWatch::Poll::kBack) std::fputs("cupola: gpio: the lines are back\n", stderr);
  }
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (inputs_[i] == InputDoes::kBlackout && watch_.active(i)) wishes.blackout = true;
  }
  wishes.held = held_;
  return wishes;
}

void ControlPanel::set(OutputIs which, bool active) noexcept {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    if (outputs_[i] == which) watch_.set(inputs_.size() + i, active);
  }
}

void ControlPanel::flipped(bool black) noexcept {
  trigger_ = !trigger_;
  set(OutputIs::kCameraTrigger, trigger_);  // first: the others are in no hurry
  set(OutputIs::kShutter, black);
  set(OutputIs::kLamp, true);
  set(OutputIs::kTally, !held_);
}

void ControlPanel::rest() noexcept {
  trigger_ = false;
  set(OutputIs::kShutter, true);
  for (const OutputIs which : {OutputIs::kLamp, OutputIs::kTally, OutputIs::kCameraTrigger})
    set(which, false);
}

}  // namespace cupola
