// Lines through libgpiod 2.x: one request a chip, each of its lines with settings of its own. When events
// overrun, the kernel drops the oldest, so that the last one is always what the line is.
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

template <auto free>
struct Free {
  template <class Thing>
  void operator()(Thing* thing) const {
    free(thing);
  }
};
using Chip = std::unique_ptr<gpiod_chip, Free<gpiod_chip_close>>;
using ChipInfo = std::unique_ptr<gpiod_chip_info, Free<gpiod_chip_info_free>>;
using LineInfo = std::unique_ptr<gpiod_line_info, Free<gpiod_line_info_free>>;
using LineSettings = std::unique_ptr<gpiod_line_settings, Free<gpiod_line_settings_free>>;
using LineConfig = std::unique_ptr<gpiod_line_config, Free<gpiod_line_config_free>>;
using RequestConfig = std::unique_ptr<gpiod_request_config, Free<gpiod_request_config_free>>;
using Request = std::unique_ptr<gpiod_line_request, Free<gpiod_line_request_release>>;
using EventBuffer = std::unique_ptr<gpiod_edge_event_buffer, Free<gpiod_edge_event_buffer_free>>;

GpioTrouble trouble_of(const char* step, int error, int line = -1) {
  const GpioCause cause = error == ENODEV || error == ENXIO ? GpioCause::kGone
                          : error == EBUSY                  ? GpioCause::kBusy
                                                            : GpioCause::kFailed;
  return {cause, step, error, line};
}

gpiod_line_value value_of(bool active) {
  return active ? GPIOD_LINE_VALUE_ACTIVE : GPIOD_LINE_VALUE_INACTIVE;
}

LineSettings settings_of(const GpioLine& line) {
  constexpr std::array<gpiod_line_bias, 4> kBias = {GPIOD_LINE_BIAS_AS_IS, GPIOD_LINE_BIAS_DISABLED,
                                                    GPIOD_LINE_BIAS_PULL_UP, GPIOD_LINE_BIAS_PULL_DOWN};
  LineSettings settings(gpiod_line_settings_new());
  if (!settings) return settings;
  gpiod_line_settings_set_direction(settings.get(),
                                    line.output ? GPIOD_LINE_DIRECTION_OUTPUT : GPIOD_LINE_DIRECTION_INPUT);
  if (line.output) {
    gpiod_line_settings_set_output_value(settings.get(), value_of(line.active));
  } else {
    gpiod_line_settings_set_edge_detection(settings.get(), GPIOD_LINE_EDGE_BOTH);
    gpiod_line_settings_set_event_clock(settings.get(), GPIOD_LINE_CLOCK_MONOTONIC);
  }
  gpiod_line_settings_set_active_low(settings.get(), line.active_low);
  gpiod_line_settings_set_bias(settings.get(), kBias[static_cast<std::size_t>(line.bias)]);
  return settings;
}

class Gpiod2Lines final : public Gpio {
 public:
  Gpiod2Lines() = default;
  ~Gpiod2Lines() override { stop(); }
  Gpiod2Lines(const Gpiod2Lines&) = delete;
  Gpiod2Lines& operator=(const Gpiod2Lines&) = delete;

  std::variant<GpioLevels, GpioTrouble> start(std::span<const GpioLine> lines) noexcept override;
  void stop() noexcept override;
  GpioPoll poll(GpioEdge& edge, GpioTrouble& trouble) noexcept override;
  std::optional<GpioTrouble> set(std::size_t line, bool active) noexcept override;
  int descriptor() const noexcept override { return epoll_; }

 private:
  struct Line {
    std::size_t bank = 0;
    unsigned offset = 0;
    bool output = false;
  };
  struct Bank {  // one chip's lines
    std::size_t chip = 0;
    Request request;
  };

  std::optional<GpioTrouble> take(std::span<const GpioLine> lines, GpioLevels& levels);
  std::optional<GpioTrouble> find(std::span<const GpioLine> lines, std::span<const Chip> chips, int refused);
  std::optional<GpioTrouble> request(Bank& bank, gpiod_chip* chip, std::span<const GpioLine> lines);
  static GpioPoll lost(const char* step, int error, int line, GpioTrouble& trouble);
  GpioPoll read(std::size_t bank, GpioEdge& edge, GpioTrouble& trouble);

  std::vector<Line> lines_;
  std::vector<Bank> banks_;
  EventBuffer event_;
  std::array<pollfd, kMostGpioLines> polled_{};
  std::size_t first_ = 0;  // which bank poll() asks first: each in turn
  int epoll_ = -1;
};

std::variant<GpioLevels, GpioTrouble> Gpiod2Lines::start(std::span<const GpioLine> lines) noexcept {
  stop();
  assert(lines.size() <= kMostGpioLines);
  GpioLevels levels;
  if (const std::optional<GpioTrouble> trouble = take(lines, levels)) {
    stop();
    return *trouble;
  }
  return levels;
}

std::optional<GpioTrouble> Gpiod2Lines::find(std::span<const GpioLine> lines, std::span<const Chip> chips,
                                             int refused) {
  std::vector<ChipInfo> infos;
  std::vector<GpioChipNames> names;
  for (const Chip& chip : chips) {
    ChipInfo info(gpiod_chip_get_info(chip.get()));
    if (!info) return trouble_of("chip info", errno);
    names.push_back({gpiod_chip_info_get_name(info.get()), gpiod_chip_info_get_label(info.get()),
                     gpiod_chip_info_get_num_lines(info.get())});
    infos.push_back(std::move(info));
  }
  const auto offset_of = [&](std::size_t chip, const std::string& name) {
    return gpiod_chip_get_line_offset_from_name(chips[chip].get(), name.c_str());
  };
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
    std::size_t bank = 0;
    while (bank < banks_.size() && banks_[bank].chip != at.chip) ++bank;
    if (bank == banks_.size()) banks_.push_back({at.chip, nullptr});
    for (const Line& other : lines_) {  // one request takes a line once; two would find it busy
      if (other.bank == bank && other.offset == at.offset) return trouble_of("request", EBUSY, place);
    }
    lines_.push_back({bank, at.offset, lines[i].output});
  }
  return std::nullopt;
}

std::optional<GpioTrouble> Gpiod2Lines::request(Bank& bank, gpiod_chip* chip,
                                                std::span<const GpioLine> lines) {
  const LineConfig config(gpiod_line_config_new());
  const RequestConfig request(gpiod_request_config_new());
  if (!config || !request) return trouble_of("request", ENOMEM);
  gpiod_request_config_set_consumer(request.get(), "cupola");
  const auto index = static_cast<std::size_t>(&bank - banks_.data());
  for (std::size_t i = 0; i < lines.size(); ++i) {
    if (lines_[i].bank != index) continue;
    const LineSettings settings = settings_of(lines[i]);
    if (!settings) return trouble_of("request", ENOMEM);
    if (gpiod_line_config_add_line_settings(config.get(), &lines_[i].offset, 1, settings.get()) != 0) {
      return trouble_of("line settings", errno, static_cast<int>(i));
    }
  }
  bank.request.reset(gpiod_chip_request_lines(chip, request.get(), config.get()));
  if (bank.request) return std::nullopt;
  GpioTrouble trouble = trouble_of("request", errno);
  for (std::size_t i = 0; i < lines.size() && trouble.cause == GpioCause::kBusy && trouble.line < 0; ++i) {
    if (lines_[i].bank != index) continue;
    const LineInfo info(gpiod_chip_get_line_info(chip, lines_[i].offset));
    if (info && gpiod_line_info_is_used(info.get())) trouble.line = static_cast<int>(i);
  }
  return trouble;
}

std::optional<GpioTrouble> Gpiod2Lines::take(std::span<const GpioLine> lines, GpioLevels& levels) {
  int refused = 0;
  std::vector<Chip> chips;
  for (const std::string& path : gpio_chip_paths()) {
    Chip chip(gpiod_chip_open(path.c_str()));
    if (chip) {
      chips.push_back(std::move(chip));
    } else if (errno == EACCES || errno == EPERM) {
      refused = errno;
    }
  }
  if (const std::optional<GpioTrouble> trouble = find(lines, chips, refused)) return trouble;
  epoll_ = epoll_create1(EPOLL_CLOEXEC);
  if (epoll_ < 0) return trouble_of("epoll_create1", errno);
  event_.reset(gpiod_edge_event_buffer_new(1));
  if (!event_) return trouble_of("event buffer", ENOMEM);
  for (Bank& bank : banks_) {
    if (const std::optional<GpioTrouble> trouble = request(bank, chips[bank.chip].get(), lines))
      return trouble;
    epoll_event event{};
    event.events = EPOLLIN;
    const int descriptor = gpiod_line_request_get_fd(bank.request.get());
    if (epoll_ctl(epoll_, EPOLL_CTL_ADD, descriptor, &event) != 0) return trouble_of("epoll_ctl", errno);
  }
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (lines_[i].output) continue;
    const gpiod_line_value level =
        gpiod_line_request_get_value(banks_[lines_[i].bank].request.get(), lines_[i].offset);
    if (level == GPIOD_LINE_VALUE_ERROR) return trouble_of("get value", errno, static_cast<int>(i));
    levels[i] = level == GPIOD_LINE_VALUE_ACTIVE;
  }
  return std::nullopt;
}

void Gpiod2Lines::stop() noexcept {
  if (epoll_ >= 0) close(epoll_);
  epoll_ = -1;
  lines_.clear();
  banks_.clear();
}

GpioPoll Gpiod2Lines::lost(const char* step, int error, int line, GpioTrouble& trouble) {
  trouble = trouble_of(step, error, line);
  return GpioPoll::kLost;
}

GpioPoll Gpiod2Lines::read(std::size_t bank, GpioEdge& edge, GpioTrouble& trouble) {
  if (gpiod_line_request_read_edge_events(banks_[bank].request.get(), event_.get(), 1) != 1) {
    return lost("read event", errno, -1, trouble);
  }
  gpiod_edge_event* event = gpiod_edge_event_buffer_get_event(event_.get(), 0);
  const unsigned offset = gpiod_edge_event_get_line_offset(event);
  for (std::size_t i = 0; i < lines_.size(); ++i) {
    if (lines_[i].bank != bank || lines_[i].offset != offset) continue;
    edge = {i, gpiod_edge_event_get_event_type(event) == GPIOD_EDGE_EVENT_RISING_EDGE,
            nanoseconds(static_cast<std::int64_t>(gpiod_edge_event_get_timestamp_ns(event)))};
    return GpioPoll::kEdge;
  }
  return lost("event of a line that was not asked for", 0, -1, trouble);
}

GpioPoll Gpiod2Lines::poll(GpioEdge& edge, GpioTrouble& trouble) noexcept {
  if (epoll_ < 0) return GpioPoll::kNothing;
  for (std::size_t i = 0; i < banks_.size(); ++i) {
    polled_[i] = {gpiod_line_request_get_fd(banks_[i].request.get()), POLLIN, 0};
  }
  if (::poll(polled_.data(), banks_.size(), 0) < 0 && errno != EINTR) return lost("poll", errno, -1, trouble);
  for (std::size_t k = 0; k < banks_.size(); ++k) {
    const std::size_t i = (first_ + k) % banks_.size();
    if (polled_[i].revents & (POLLHUP | POLLERR | POLLNVAL)) return lost("poll", ENODEV, -1, trouble);
    if ((polled_[i].revents & POLLIN) == 0) continue;
    first_ = i + 1;
    return read(i, edge, trouble);
  }
  return GpioPoll::kNothing;
}

std::optional<GpioTrouble> Gpiod2Lines::set(std::size_t line, bool active) noexcept {
  if (epoll_ < 0) return GpioTrouble{GpioCause::kGone, "set value", 0, static_cast<int>(line)};
  const Line& output = lines_[line];
  if (gpiod_line_request_set_value(banks_[output.bank].request.get(), output.offset, value_of(active)) == 0) {
    return std::nullopt;
  }
  return trouble_of("set value", errno, static_cast<int>(line));
}

}  // namespace

std::unique_ptr<Gpio> make_gpiod_lines(Clock&) {
  return std::make_unique<Gpiod2Lines>();
}

std::vector<GpioChip> list_gpio_chips() {
  std::vector<GpioChip> chips;
  for (const std::string& path : gpio_chip_paths()) {
    GpioChip& found = chips.emplace_back();
    found.path = path;
    const Chip chip(gpiod_chip_open(path.c_str()));
    const ChipInfo info(chip ? gpiod_chip_get_info(chip.get()) : nullptr);
    if (!info) {
      found.trouble = std::strerror(errno);
      continue;
    }
    found.label = gpiod_chip_info_get_label(info.get());
    found.lines = static_cast<int>(gpiod_chip_info_get_num_lines(info.get()));
    for (int i = 0; i < found.lines; ++i) {
      const LineInfo line(gpiod_chip_get_line_info(chip.get(), static_cast<unsigned>(i)));
      const char* name = line ? gpiod_line_info_get_name(line.get()) : nullptr;
      if (name && *name) found.line_names.emplace_back(name);
    }
  }
  return chips;
}

}  // namespace cupola
