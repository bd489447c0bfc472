// Lines of memory: what presses their buttons and pulls their plug is a script by the fake clock.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <chrono>
#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "hal/gpio/gpio.h"
#include "hal/time/clock.h"

namespace cupola {

struct FakeGpioChip {
  std::string label;
  std::vector<std::string> lines;
};

// What a driver did to a pin.
struct FakeGpioWrite {
  std::string_view line;
  bool high = false;  // the pin's own level, whatever active_low says
  std::chrono::nanoseconds at{0};
};

enum class FakeGpioCall : std::uint8_t { kStart, kPoll, kSet };

class FakeGpio final : public Gpio {
 public:
  // Pins are low at first. Names of lines are the chips' own: none twice. `clock` is borrowed.
  FakeGpio(FakeClock& clock, std::vector<FakeGpioChip> chips);

  // The world around it. Steps are taken when the clock has got there, in the order of their times. `line`
  // and `chip` are names that were given to the constructor.
  void pull(std::string_view line, bool high, std::chrono::nanoseconds at);
  // `edges` changes, one every `apart`, the last of them to `high`; an even number begins with a false one.
  void bounce(std::string_view line, bool high, std::chrono::nanoseconds at, int edges,
              std::chrono::nanoseconds apart);
  void unplug(std::string_view chip, std::chrono::nanoseconds at);  // its outputs go low
  void plug(std::string_view chip, std::chrono::nanoseconds at);
  // From now on somebody else has the line, or no longer.
  void take(std::string_view line, bool taken);
  // The next `times` calls of that kind fail with `error`; one of a poll means that a chip is gone.
  void refuse(FakeGpioCall call, int error, int times);

  bool high(std::string_view line);                                     // the pin, now
  const std::vector<FakeGpioWrite>& writes() const { return writes_; }  // the first 65536
  int starts() const { return starts_; }                                // those that succeeded

  std::variant<GpioLevels, GpioTrouble> start(std::span<const GpioLine> lines) noexcept override;
  void stop() noexcept override;
  GpioPoll poll(GpioEdge& edge, GpioTrouble& trouble) noexcept override;
  std::optional<GpioTrouble> set(std::size_t line, bool active) noexcept override;
  int descriptor() const noexcept override { return working_ ? alarm_ : -1; }

 private:
  enum class Act : std::uint8_t { kPull, kUnplug, kPlug };
  struct Step {
    std::chrono::nanoseconds at;
    Act act;
    std::size_t target;  // of pins_ or of chips_
    bool high;
  };
  struct Pin {
    std::string name;
    std::size_t chip = 0;
    bool high = false;
    bool taken = false;
  };
  struct Chip {
    std::string label;
    std::size_t first_pin = 0;
    std::size_t pins = 0;
    bool there = true;
    bool lost = false;  // went while its lines were at work
  };
  // As the kernel keeps them: 16 events a line, newer ones are dropped.
  struct Queue {
    struct Event {
      bool active;
      std::chrono::nanoseconds at;
    };
    std::array<Event, 16> events;
    std::size_t count = 0;
    bool handed = false;     // the level handed out last
    bool unchecked = false;  // against the pin, since
  };
  struct Line {
    std::size_t pin = 0;
    bool output = false;
    bool active_low = false;
    Queue queue;
  };

  std::size_t pin(std::string_view name) const;
  std::size_t chip(std::string_view label) const;
  void add(Step step);
  void step_world() noexcept;
  void write(const Line& line, bool active) noexcept;
  void set_alarm() noexcept;
  bool fails(FakeGpioCall call, int& error) noexcept;

  FakeClock& clock_;
  int alarm_;
  std::vector<Chip> chips_;
  std::vector<Pin> pins_;
  std::vector<Step> script_;  // in the order of time
  std::size_t next_step_ = 0;
  std::vector<Line> lines_;
  std::vector<FakeGpioWrite> writes_;
  struct Refusal {
    int error = 0;
    int times = 0;
  };
  std::array<Refusal, 3> refusals_;
  bool working_ = false;
  int starts_ = 0;
};

}  // namespace cupola
