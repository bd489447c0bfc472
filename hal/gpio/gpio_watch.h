// Keeps a set of lines at work: debounces the inputs, brings back a lost chip with its outputs as they were,
// and counts.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "hal/gpio/debouncer.h"
#include "hal/gpio/gpio.h"
#include "hal/time/clock.h"

namespace cupola {

enum class GpioState : std::uint8_t { kWorking, kLost };

struct GpioCounts {
  std::uint64_t raw_edges = 0;  // that the driver reported
  std::uint64_t edges = 0;      // handed on
  std::uint64_t losses = 0;     // times that lines which worked no longer did
  std::uint64_t returns = 0;    // times that they did again
  std::uint64_t failed_starts = 0;
};

class GpioWatch {
 public:
  // `gpio` and `clock` are borrowed for the watch's life. Lines are tried for every 100 ms while they are
  // lost.
  GpioWatch(Gpio& gpio, std::vector<GpioLine> lines, Clock& clock);
  ~GpioWatch();
  GpioWatch(const GpioWatch&) = delete;
  GpioWatch& operator=(const GpioWatch&) = delete;

  enum class Poll : std::uint8_t {
    kEdge,
    kNothing,
    kLost,  // said once a loss, and when the first start fails
    kBack,  // said once a return. active() is news: what was pressed meanwhile is no edge
  };
  // One debounced edge, if there is any. Starts the lines when they are not at work and their time has come.
  // Does not wait; allocates only in a start. To be called until it says kNothing.
  Poll poll(GpioEdge& edge) noexcept;
  // Kept while the lines are lost.
  void set(std::size_t line, bool active) noexcept;
  // Inputs: debounced, as last known; outputs: as they were wanted.
  bool active(std::size_t line) const noexcept;

  int descriptor() const noexcept { return gpio_.descriptor(); }
  // When poll() should be called at the latest.
  std::chrono::nanoseconds deadline() const noexcept;
  GpioState state() const noexcept { return state_; }
  const GpioTrouble& trouble() const noexcept { return trouble_; }  // of the last loss or failed start
  const GpioCounts& counts() const noexcept { return counts_; }
  std::span<const GpioLine> lines() const noexcept { return lines_; }

 private:
  bool start() noexcept;
  void lose(const GpioTrouble& trouble) noexcept;
  bool hand_on(std::size_t line, std::chrono::nanoseconds now, GpioEdge& edge) noexcept;

  Gpio& gpio_;
  std::vector<GpioLine> lines_;  // outputs: `active` is what is wanted
  std::vector<Debouncer> debouncers_;
  Clock& clock_;
  GpioState state_ = GpioState::kLost;
  GpioTrouble trouble_;
  GpioCounts counts_;
  std::optional<GpioEdge> waiting_;  // from the driver: the line's earlier edges are to be handed on first
  bool started_ = false;             // ever
  bool to_say_lost_ = false;
  bool said_lost_ = false;
  std::chrono::nanoseconds next_start_{0};  // while lost
  std::chrono::nanoseconds last_poll_{0};
};

}  // namespace cupola
