// A display of memory: flips by the given clock and keeps the last frame, for tests and for timing.
// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "hal/display/display.h"
#include "hal/time/clock.h"

namespace cupola {

class FakeDisplay final : public Display {
 public:
  // Flips every `period`, the first time one period from now. `clock` is borrowed for the display's life.
  FakeDisplay(Clock& clock, int width, int height, std::chrono::nanoseconds period);
  FakeDisplay(Clock& clock, int width, int height)
      : FakeDisplay(clock, width, height, std::chrono::nanoseconds(std::chrono::seconds(1)) / 60) {}

  DisplayBuffer back_buffer() noexcept override;
  bool prepare_nv12(ScanoutColour colour) override;
  DisplayBuffer back_nv12() noexcept override;
  Presented present(std::chrono::nanoseconds when) noexcept override;
  Presented repeat(std::chrono::nanoseconds when) noexcept override;
  std::chrono::nanoseconds period() const noexcept override { return period_; }
  const char* trouble() const noexcept override { return trouble_; }

  // The screen is away for the flips from `from` to before `until`; the one that comes back has another
  // period unless `period_after` is 0.
  struct Absence {
    std::chrono::nanoseconds from;
    std::chrono::nanoseconds until;
    std::chrono::nanoseconds period_after{0};
  };
  void set_absences(std::vector<Absence> one_after_the_other);

  // It takes NV12, when prepare_nv12() is called.
  void take_nv12() { can_nv12_ = true; }
  ScanoutColour nv12_colour() const { return colour_; }

  // From the next present() on.
  void close() { fate_ = Present::kClosed; }
  void lose() { fate_ = Present::kLost; }

  std::int64_t frames() const { return frames_; }  // flips to a new or the same frame
  // The frame on the screen, or that it would show were it there; all zero before the first.
  DisplayBuffer front_buffer() noexcept;
  // FNV-1a over the words of the frame on the screen, which is XRGB8888, row by row.
  std::uint64_t front_hash() noexcept;

 private:
  DisplayBuffer buffer(std::size_t index) noexcept;
  DisplayBuffer back(bool nv12) noexcept;

  Clock& clock_;
  int width_;
  int height_;
  std::chrono::nanoseconds period_;
  std::chrono::nanoseconds last_flip_;
  struct Memory {
    std::vector<std::uint32_t> words;
    std::vector<std::byte> nv12;  // empty: not prepared
    bool is_nv12 = false;         // which of them counts
  };
  std::array<Memory, 2> memory_;
  bool can_nv12_ = false;
  ScanoutColour colour_;
  std::size_t back_ = 0;
  std::int64_t presents_ = 0;
  std::int64_t frames_ = 0;
  Present fate_ = Present::kShown;
  std::vector<Absence> absences_;
  std::size_t absence_ = 0;  // the one that is now or next
  const char* trouble_ = "";
};

}  // namespace cupola
