// What the operator's lines mean.
// SPDX-License-Identifier: MIT
#include "firmware/control_panel.h"

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

ControlPanel::ControlPanel(const GpioSettings& settings, Gpio& gpio, Clock& clock, EventLog& log)
    : watch_(gpio, lines_of(settings), clock), log_(log) {
  for (const PanelInput& input : settings.inputs) inputs_.push_back(input.press);
  for (const PanelOutput& output : settings.outputs) outputs_.push_back(output.is);
  poll_lines(nullptr);
}

bool ControlPanel::poll(CommandQueue& commands) noexcept {
  return poll_lines(&commands);
}

bool ControlPanel::poll_lines(CommandQueue* commands) noexcept {
  bool dark = false;
  GpioEdge edge;
  for (int i = 0; i < kMostEdges; ++i) {
    const GpioWatch::Poll said = watch_.poll(edge);
    if (said == GpioWatch::Poll::kNothing) break;
    if (said == GpioWatch::Poll::kEdge && edge.active) {
      const std::optional<PlayerCommand>& press = inputs_[edge.line];
      if (!press) {
        dark = true;  // even if it was let go before the frame
      } else if (commands) {
        commands->push(*press);
      }
    }
    if (said == GpioWatch::Poll::kLost) {
      log_.warn(Topic::kControl, "gpio: " + describe(watch_.trouble(), watch_.lines()));
    }
    if (said == GpioWatch::Poll::kBack) log_.notice(Topic::kControl, "gpio: the lines are back");
  }
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    if (!inputs_[i] && watch_.active(i)) dark = true;
  }
  return dark;
}

void ControlPanel::set(OutputIs which, bool active) noexcept {
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    if (outputs_[i] == which) watch_.set(inputs_.size() + i, active);
  }
}

void ControlPanel::flipped(bool black, bool held) noexcept {
  trigger_ = !trigger_;
  set(OutputIs::kCameraTrigger, trigger_);  // first: the others are in no hurry
  set(OutputIs::kShutter, black);
  set(OutputIs::kLamp, true);
  set(OutputIs::kTally, !held);
}

void ControlPanel::rest() noexcept {
  trigger_ = false;
  set(OutputIs::kShutter, true);
  for (const OutputIs which : {OutputIs::kLamp, OutputIs::kTally, OutputIs::kCameraTrigger})
    set(which, false);
}

}  // namespace cupola
