// Buttons, lamps and triggers: named input and output lines of GPIO chips.
// SPDX-License-Identifier: MIT
#pragma once

#include <bitset>
#include <chrono>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <variant>

namespace cupola {

constexpr std::size_t kMostGpioLines = 64;

enum class GpioBias : std::uint8_t { kAsIs, kNone, kPullUp, kPullDown };

// Which changes of an input are handed on by GpioWatch. Drivers see both: without the other one nothing can
// be debounced.
enum class GpioEdges : std::uint8_t { kBoth, kToActive, kToInactive };

// kSettled: a change counts once the line has been quiet for the debounce time; a spike never does.
// kAtOnce: it counts at its first edge, and the line's answer to that is awaited afterwards; a spike counts.
enum class GpioDebounce : std::uint8_t { kSettled, kAtOnce };

// A line is found by its name (as the device tree or the driver has it) or by chip and offset. Chips change
// their numbers when they are plugged in again; their labels stay.
struct GpioLine {
  std::string name;
  std::string chip;  // its label or name; with a line's name it may be empty: any chip
  int offset = -1;   // on the chip, instead of a name
  bool output = false;
  bool active_low = false;
  GpioBias bias = GpioBias::kAsIs;
  GpioEdges edges = GpioEdges::kBoth;
  GpioDebounce debounce_kind = GpioDebounce::kSettled;
  std::chrono::microseconds debounce{0};
  bool active = false;  // an output's first value
};

enum class GpioCause : std::uint8_t {
  kMissing,  // no chip or no line of that name
  kBusy,     // somebody else has the line
  kGone,     // the chip was unplugged
  kFailed,   // the driver refused a call
};

struct GpioTrouble {
  GpioCause cause = GpioCause::kFailed;
  const char* step = "";  // what failed, in static storage
  int error = 0;          // errno, or 0
  int line = -1;          // its place among the lines, where it is known
};

// Bit i: line i is active.
using GpioLevels = std::bitset<kMostGpioLines>;

struct GpioEdge {
  std::size_t line = 0;            // its place among the lines
  bool active = false;             // what it became
  std::chrono::nanoseconds at{0};  // CLOCK_MONOTONIC
};

enum class GpioPoll : std::uint8_t {
  kEdge,     // `edge` is the oldest of its line that was not polled yet
  kNothing,  // there is none
  kLost,     // a chip is gone: nothing works until the lines are started again; `trouble` says why
};

// A driver's side; it neither debounces nor retries: GpioWatch does. One thread at a time. start() may take
// as long as the device does and may allocate; the others do not. Values are logical: active_low is undone.
class Gpio {
 public:
  virtual ~Gpio() = default;
  // Takes at most kMostGpioLines lines, all or none; stops first where it runs. The levels are those of
  // the inputs then.
  virtual std::variant<GpioLevels, GpioTrouble> start(std::span<const GpioLine> lines) noexcept = 0;
  virtual void stop() noexcept = 0;
  // After any number of edges, merged and overrun ones too, the last one handed out is what the line is.
  // To be called ten times a second or more: not every kernel wakes descriptor() when a chip goes.
  virtual GpioPoll poll(GpioEdge& edge, GpioTrouble& trouble) noexcept = 0;
  // Sets output `line`.
  virtual std::optional<GpioTrouble> set(std::size_t line, bool active) noexcept = 0;
  // Can be read when poll() has an edge; -1 while stopped.
  virtual int descriptor() const noexcept = 0;
};

// "no such line", ...
const char* name_of(GpioCause cause);
// "lamp-enable: taken by somebody else (request: Device or resource busy)"
std::string describe(const GpioTrouble& trouble, std::span<const GpioLine> lines);
// "lamp-enable" or "chip soc, line 4"
std::string describe(const GpioLine& line);

}  // namespace cupola
