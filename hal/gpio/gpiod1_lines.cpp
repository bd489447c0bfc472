// Lines through libgpiod 1.6: one request a line, since all lines of a request would have to be alike.
// SPDX-License-Identifier: MIT
#include <array>
#include <cassert>
#include <cerrno>
#include <cstring>
#include <memory>
#include <vector>

#include <gpiod.h>
#include <poll.h>
#include <sys/epoll.h>
#include <unistd.h>

#include "hal/gpio/gpio_search.h"
#include "hal/gpio/gpiod_chips.h"
#include "hal/gpio/gpiod_lines.h"

namespace cupola {
namespace {

using std::chrono::nanoseconds;

struct CloseChip {
  void operator()(gpiod_chip* chip) const { gpiod_chip_close(chip); }  // and releases its lines
};
using Chip = std::unique_ptr<gpiod_chip, CloseChip>;

GpioTrouble trouble_of(const char* step, int error, int line = -1) {
  const GpioCause cause = error == ENODEV || error == ENXIO ? GpioCause::kGone
                          : error == EBUSY                  ? GpioCause::kBusy
                                                            : GpioCause::kFailed;
  return {cause, step, error, line};
}

gpiod_line_request_config request_of(const GpioLine& line) {
  int flags = line.active_low ? GPIOD_LINE_REQUEST_FLAG_ACTIVE_LOW : 0;
  switch (line.bias) {
    case GpioBias::kAsIs:
      break;
    case GpioBias::kNone:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_DISABLE;
      break;
    case GpioBias::kPullUp:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_UP;
      break;
    case GpioBias::kPullDown:
      flags |= GPIOD_LINE_REQUEST_FLAG_BIAS_PULL_DOWN;
      break;
  }
  return {"cupola", line.output ? GPIOD_LINE_REQUEST_DIRECTION_OUTPUT : GPIOD_LINE_REQUEST_EVENT_BOTH_EDGES,
          flags};
}

class Gpiod1Lines final : public Gpio {
 public:
  explicit Gpiod1Lines(Clock& clock) : clock_(clock) {}
  ~Gpiod1Lines() override { stop(); }
  Gpiod1Lines(const Gpiod1Lines&) = delete;
  Gpiod1Lines& operator=(const Gpiod1Lines&) = delete;

  std::variant<GpioLevels, GpioTrouble> start(std::span<const GpioLine> lines) noexcept override;
  void stop() noexcept override;
  GpioPoll poll(GpioEdge& edge, GpioTrouble& trouble) noexcept override;
  std::optional<GpioTrouble> set(std::size_t line, bool active) noexcept override;
  int descriptor() const noexcept override { return epoll_; }

 private:
  struct Line {
    gpiod_line* line = nullptr;
    int descriptor = -1;     // of an input's events
    bool active = false;     // an input's last edge, or its level at the start
    bool unchecked = false;  // since that edge: when events overrun, the newest are those that are missing
  };

  std::optional<GpioTrouble> take(std::span<const GpioLine> lines, GpioLevels& levels);
  GpioPoll lost(const char* step, int error, int line, GpioTrouble& trouble) const;
  GpioPoll read(std::size_t line, GpioEdge& edge, GpioTrouble& trouble);

  Clock& clock_;
  std::vector<Chip> chips_;
  std::vector<Line> lines_;
  std::vector<gpiod_line*> watched_;  // one a chip
  std::array<pollfd, kMostGpioLines> polled_{};
  std::size_t first_ = 0;  // whom poll() asks first: each in turn
  int epoll_ = -1;
};

std::variant<GpioLevels, GpioTrouble> Gpiod1Lines::start(std::span<const GpioLine> lines) noexcept {
  stop();
  assert(lines.size() <= kMostGpioLines);
  GpioLevels levels;
  if (const std::optional<GpioTrouble> trouble = take(lines, levels)) {
    stop();
    return *trouble;
  }
  return levels;
}

std::optional<GpioTrouble> Gpiod1Lines::take(std::span<const GpioLine> lines, GpioLevels& levels) {
  int refused = 0;
  for (const std::string& path : gpio_chip_paths()) {
    Chip chip(gpiod_chip_open(path.c_str()));
    if (chip) {
      chips_.push_back(std::move(chip));
    } else if (errno == EACCES || errno == EPERM) {
      refused = errno;
    }
  }
  std::vector<GpioChipNames> names;
  for (const Chip& chip : chips_) {
    names.push_back(
        {gpiod_chip_name(chip.get()), gpiod_chip_label(chip.get()), gpiod_chip_num_lines(chip.get())});
  }
  const auto offset_of = [&](std::size_t chip, const std::string& name) {
    gpiod_line* line = gpiod_chip_find_line(chips_[chip].get(), name.c_str());
    return line ? static_cast<int>(gpiod_line_offset(line)) : -1;
  };
  epoll_ = epoll_create1(EPOLL_CLOEXEC);
  if (epoll_ < 0) return trouble_of("epoll_create1", errno);
  std::vector<bool> used(chips_.size());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    const int place = static_cast<int>(i);
    auto found = find_line(lines[i], names, offset_of);
    if (auto* trouble = std::get_if<GpioTrouble>(&found)) {
      trouble->line = place;
      if (refused != 0 && trouble->cause == GpioCause::kMissing)
        return trouble_of("open chip", refused, place);
      return *trouble;
    }
    const FoundLine at = std::get<FoundLine>(found);
    Line line;
    line.line = gpiod_chip_get_line(chips_[at.chip].get(), at.offset);
    if (!line.line) return trouble_of("line info", errno, place);
    const gpiod_line_request_config request = request_of(lines[i]);
    if (gpiod_line_request(line.line, &request, lines[i].active ? 1 : 0) != 0) {
      return trouble_of("request", errno, place);
    }
    if (!lines[i].output) {
      line.descriptor = gpiod_line_event_get_fd(line.line);
      epoll_event event{};
      event.events = EPOLLIN;
      if (epoll_ctl(epoll_, EPOLL_CTL_ADD, line.descriptor, &event) != 0) {
        return trouble_of("epoll_ctl", errno, place);
      }
      const int level = gpiod_line_get_value(line.line);
      if (level < 0) return trouble_of("get value", errno, place);
      levels[i] = line.active = level > 0;
    }
    if (!used[at.chip]) watched_.push_back(line.line);
    used[at.chip] = true;
    lines_.push_back(line);
  }
  for (std::size_t i = 0; i < chips_.size(); ++i) {
    if (!used[i]) chips_[i].reset();
  }
  return std::nullopt;
}

void Gpiod1Lines::stop() noexcept {
  if (epoll_ >= 0) close(epoll_);
  epoll_ = -1;
  lines_.clear();
  watched_.clear();
  chips_.clear();
}

GpioPoll Gpiod1Lines::lost(const char* step, int error, int line, GpioTrouble& trouble) const {
  trouble = trouble_of(step, error, line);
  return GpioPoll::kLost;
}

GpioPoll Gpiod1Lines::read(std::size_t index, GpioEdge& edge, GpioTrouble& trouble) {
  Line& line = lines_[index];
  gpiod_line_event event{};
  if (gpiod_line_event_read_fd(line.descriptor, &event) != 0) {
    return lost("read event", errno, static_cast<int>(index), trouble);
  }
  line.active = event.event_type == GPIOD_LINE_EVENT_RISING_EDGE;
  line.unchecked = true;
  edge = {index, line.active, std::chrono::seconds(event.ts.tv_sec) + nanoseconds(event.ts.tv_nsec)};
  return GpioPoll::kEdge;
}

GpioPoll Gpiod1Lines::poll(GpioEdge& edge, GpioTrouble& trouble) noexcept {
  if (epoll_ < 0) return GpioPoll::kNothing;
  for (std::size_t i = 0; i < lines_.size(); ++i) polled_[i] = {lines_[i].descriptor, POLLIN, 0};
  if (::poll(polled_.data(), lines_.size(), 0) < 0 && errno != EINTR) return lost("poll", errno, -1, trouble);
  for (std::size_t k = 0; k < lines_.size(); ++k) {
    const std::size_t i = (first_ + k) % lines_.size();
    Line& line = lines_[i];
    if (polled_[i].revents & POLLIN) {
      first_ = i + 1;
      return read(i, edge, trouble);
    }
    if (!line.unchecked) continue;
    line.unchecked = false;
    const int level = gpiod_line_get_value(line.line);
    if (level < 0) return lost("get value", errno, static_cast<int>(i), trouble);
    if ((level > 0) == line.active) continue;
    line.active = level > 0;
    edge = {i, line.active, clock_.now()};
    return GpioPoll::kEdge;
  }
  // Whether the chips are there still: outputs have nothing to poll. Asking about a line does not touch the
  // hardware.
  for (gpiod_line* line : watched_) {
    if (gpiod_line_update(line) != 0) return lost("line info", errno, -1, trouble);
  }
  return GpioPoll::kNothing;
}

std::optional<GpioTrouble> Gpiod1Lines::set(std::size_t line, bool active) noexcept {
  if (epoll_ < 0) return GpioTrouble{GpioCause::kGone, "set value", 0, static_cast<int>(line)};
  if (gpiod_line_set_value(lines_[line].line, active ? 1 : 0) == 0) return std::nullopt;
  return trouble_of("set value", errno, static_cast<int>(line));
}

}  // namespace

std::unique_ptr<Gpio> make_gpiod_lines(Clock& clock) {
  return std::make_unique<Gpiod1Lines>(clock);
}

std::vector<GpioChip> list_gpio_chips() {
  std::vector<GpioChip> chips;
  for (const std::string& path : gpio_chip_paths()) {
    GpioChip& found = chips.emplace_back();
    found.path = path;
    const Chip chip(gpiod_chip_open(path.c_str()));
    if (!chip) {
      found.trouble = std::strerror(errno);
      continue;
    }
    found.label = gpiod_chip_label(chip.get());
    found.lines = static_cast<int>(gpiod_chip_num_lines(chip.get()));
    for (int i = 0; i < found.lines; ++i) {
      gpiod_line* line = gpiod_chip_get_line(chip.get(), static_cast<unsigned>(i));
      const char* name = line ? gpiod_line_name(line) : nullptr;
      if (name && *name) found.line_names.emplace_back(name);
    }
  }
  return chips;
}

}  // namespace cupola
