// Each driver is asked in its own way; what it answers becomes a row.
// SPDX-License-Identifier: MIT
#include "firmware/device_list.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <nlohmann/json.hpp>

#ifdef CUPOLA_V4L2
#include "hal/camera/system_calls.h"
#include "hal/camera/v4l2_devices.h"
#endif
#ifdef CUPOLA_LIBCAMERA
#include "hal/camera/libcamera_system.h"
#endif
#ifdef CUPOLA_KMS
#include "hal/display/kms_device.h"
#endif
#ifdef CUPOLA_GL
#include "hal/gl/offscreen_gl.h"
#endif
#include "hal/gpio/gpiod_chips.h"

namespace cupola {
namespace {

using Rows = std::vector<FoundDevice>;

FoundDevice none(const char* kind, const char* driver, const char* why) {
  return {kind, driver, "", "", why};
}

[[maybe_unused]] FoundDevice not_built_in(const char* kind, const char* driver) {
  return {kind, driver, "", "", "this program was built without it"};
}

void add_v4l2(Rows& rows) {
#ifdef CUPOLA_V4L2
  LinuxCalls calls;
  const std::vector<V4l2Device> devices = list_v4l2_devices(calls);
  if (devices.empty()) rows.push_back(none("camera", "v4l2", "there is no /dev/video"));
  for (const V4l2Device& device : devices) {
    rows.push_back({"camera", "v4l2", device.path,
                    fmt::format("{} ({}), {}", device.card, device.driver, device.bus),
                    device.unusable ? describe(*device.unusable) : ""});
  }
#else
  rows.push_back(not_built_in("camera", "v4l2"));
#endif
}

void add_libcamera(Rows& rows) {
#ifdef CUPOLA_LIBCAMERA
  LibcameraSystem system;
  if (system.trouble()) rows.push_back({"camera", "libcamera", "", "", describe(*system.trouble())});
  const std::vector<LibcameraListing> cameras = system.list();
  if (cameras.empty() && !system.trouble()) {
    rows.push_back(none("camera", "libcamera", "libcamera finds no camera"));
  }
  for (const LibcameraListing& camera : cameras) {
    rows.push_back({"camera", "libcamera", camera.id, camera.model, camera.trouble});
  }
#else
  rows.push_back(not_built_in("camera", "libcamera"));
#endif
}

void add_gpio(Rows& rows) {
  const std::vector<GpioChip> chips = list_gpio_chips();
  if (chips.empty()) rows.push_back(none("gpio", "libgpiod", "there is no /dev/gpiochip"));
  for (const GpioChip& chip : chips) {
    std::string named;
    for (const std::string& line : chip.line_names) named += (named.empty() ? ": " : " ") + line;
    rows.push_back({"gpio", "libgpiod", chip.label,
                    fmt::format("{}, {} lines{}", chip.path, chip.lines, named), chip.trouble});
  }
}

void add_kms(Rows& rows) {
#ifdef CUPOLA_KMS
  const std::vector<KmsCard> cards = list_kms_cards();
  if (cards.empty()) rows.push_back(none("display", "kms", "there is no card in /dev/dri"));
  for (const KmsCard& card : cards) {
    if (!card.trouble.empty())
      rows.push_back({"display", "kms", card.path.string(), card.driver, card.trouble});
    for (const KmsConnector& connector : card.connectors) {
      const auto best = std::find_if(connector.modes.begin(), connector.modes.end(),
                                     [](const KmsMode& mode) { return mode.preferred; });
      std::string modes = fmt::format("{} modes", connector.modes.size());
      if (best != connector.modes.end()) modes += ", best " + name_of(*best);
      rows.push_back({"display", "kms", connector.name,
                      fmt::format("{} ({}), {}", card.path.string(), card.driver, modes),
                      connector.connected ? "" : "nothing plugged in"});
    }
  }
#else
  rows.push_back(not_built_in("display", "kms"));
#endif
}

void add_gl(Rows& rows) {
#ifdef CUPOLA_GL
  for (const char* context : {"egl-surfaceless", "egl-gbm", "egl-default", "osmesa"}) {
    const OpenedGl opened = open_offscreen_gl(16, 16, context);
    FoundDevice row{"gl", "offscreen", context, "", ""};
    if (opened.context) {
      const GlDescription& found = opened.context->description();
      row.details = fmt::format("{}, {}", found.renderer, found.version);
    } else {
      row.problem = opened.refused.empty() ? "cannot be opened" : opened.refused.back().reason;
    }
    rows.push_back(std::move(row));
  }
#else
  rows.push_back(not_built_in("gl", "offscreen"));
#endif
}

}  // namespace

std::vector<FoundDevice> find_devices() {
  Rows rows;
  add_v4l2(rows);
  add_libcamera(rows);
  add_gpio(rows);
  add_kms(rows);
  add_gl(rows);
  return rows;
}

std::string table_of(const std::vector<FoundDevice>& devices) {
  std::vector<std::array<std::string, 4>> lines = {{"KIND", "DRIVER", "NAME", "WHAT IT IS"}};
  for (const FoundDevice& device : devices) {
    std::string what = device.details;
    if (!device.problem.empty())
      what += (what.empty() ? "cannot be used: " : "; cannot be used: ") + device.problem;
    lines.push_back({device.kind, device.driver, device.name.empty() ? "-" : device.name, what});
  }
  std::array<std::size_t, 3> widths{};
  for (const auto& line : lines) {
    for (std::size_t i = 0; i < widths.size(); ++i) widths[i] = std::max(widths[i], line[i].size());
  }
  std::string table;
  for (const auto& line : lines) {
    table += fmt::format("{:{}}  {:{}}  {:{}}  {}\n", line[0], widths[0], line[1], widths[1], line[2],
                         widths[2], line[3]);
  }
  return table;
}

std::string json_of(const std::vector<FoundDevice>& devices) {
  nlohmann::ordered_json array = nlohmann::ordered_json::array();
  for (const FoundDevice& device : devices) {
    array.push_back({{"kind", device.kind},
                     {"driver", device.driver},
                     {"name", device.name},
                     {"details", device.details},
                     {"usable", device.problem.empty() && !device.name.empty()},
                     {"problem", device.problem}});
  }
  return array.dump(2, ' ', false, nlohmann::ordered_json::error_handler_t::replace) + "\n";
}

}  // namespace cupola
