// Sizes compare exactly, rates to half a flip a second: 59.94 and 60 stay apart where a projector has both.
// SPDX-License-Identifier: MIT
#include "hal/display/kms_mode.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstdio>

namespace cupola {
namespace {

double rate_of(const KmsMode& mode) {
  return 1e9 / static_cast<double>(mode.period.count());
}

// Removes a number from the front of `text`.
template <class Number>
bool take(std::string_view& text, Number& number) {
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), number);
  if (error != std::errc() || !(number > 0) || !(number < 65536)) return false;
  text.remove_prefix(static_cast<std::size_t>(end - text.data()));
  return true;
}

std::string name_of(const KmsModeWish& wish) {
  char text[64];
  const int size = std::snprintf(text, sizeof text, "%dx%d", wish.width, wish.height);
  if (wish.rate > 0)
    std::snprintf(text + size, sizeof text - static_cast<std::size_t>(size), "@%g", wish.rate);
  return text;
}

std::string names_of(std::span<const KmsMode> modes) {
  std::vector<std::string> names;
  for (const KmsMode& mode : modes) {
    const std::string name = cupola::name_of(mode);
    if (mode.progressive && std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
  }
  std::string list;
  for (const std::string& name : names) list += (list.empty() ? "" : ", ") + name;
  return list;
}

}  // namespace

std::optional<KmsModeWish> parse_kms_mode(std::string_view text) {
  KmsModeWish wish;
  if (text.empty()) return wish;
  if (!take(text, wish.width) || !text.starts_with('x')) return {};
  text.remove_prefix(1);
  if (!take(text, wish.height)) return {};
  if (text.starts_with('@')) {
    text.remove_prefix(1);
    if (!take(text, wish.rate)) return {};
  }
  if (!text.empty()) return {};
  return wish;
}

KmsModeChoice choose_kms_mode(std::span<const KmsMode> modes, const KmsModeWish& wish, int frame_width,
                              int frame_height) noexcept {
  const auto suits = [&](const KmsMode& mode) {
    return mode.progressive &&
           (wish.width == 0 || (mode.width == wish.width && mode.height == wish.height)) &&
           (wish.rate <= 0 || std::abs(rate_of(mode) - wish.rate) <= 0.5);
  };
  const auto better = [&](const KmsMode& a, const KmsMode& b) {
    if (wish.rate > 0) {
      const double off_a = std::abs(rate_of(a) - wish.rate);
      const double off_b = std::abs(rate_of(b) - wish.rate);
      if (std::abs(off_a - off_b) > 1e-3) return off_a < off_b;
    }
    if (a.preferred != b.preferred) return a.preferred;
    const std::int64_t area_a = std::int64_t{a.width} * a.height;
    const std::int64_t area_b = std::int64_t{b.width} * b.height;
    return area_a != area_b ? area_a > area_b : a.period < b.period;
  };
  std::size_t best = modes.size();
  for (std::size_t i = 0; i < modes.size(); ++i) {
    if (suits(modes[i]) && (best == modes.size() || better(modes[i], modes[best]))) best = i;
  }
  if (best == modes.size()) {
    return {0, modes.empty() ? KmsModeTrouble::kNoModes : KmsModeTrouble::kNoSuchMode};
  }
  const bool holds = frame_width <= modes[best].width && frame_height <= modes[best].height;
  return {best, holds ? KmsModeTrouble::kNone : KmsModeTrouble::kFrameLarger};
}

std::string describe(const KmsModeChoice& choice, const KmsConnector& connector, const KmsModeWish& wish,
                     int frame_width, int frame_height) {
  switch (choice.trouble) {
    case KmsModeTrouble::kNone:
      break;
    case KmsModeTrouble::kNoModes:
      return connector.name + " has no modes";
    case KmsModeTrouble::kNoSuchMode:
      return connector.name + " has no " + (wish.width > 0 ? "mode " + name_of(wish) : "progressive mode") +
             "; it has " + names_of(connector.modes);
    case KmsModeTrouble::kFrameLarger: {
      std::vector<KmsMode> larger;
      for (const KmsMode& mode : connector.modes) {
        if (mode.width >= frame_width && mode.height >= frame_height) larger.push_back(mode);
      }
      const std::string list = names_of(larger);
      return "the frame of " + std::to_string(frame_width) + "x" + std::to_string(frame_height) +
             " is larger than the mode " + name_of(connector.modes[choice.index]) + " of " + connector.name +
             (list.empty() ? "; no other is large enough" : "; these are large enough: " + list);
    }
  }
  return connector.name + " takes " + name_of(connector.modes[choice.index]);
}

std::optional<std::size_t> choose_kms_connector(std::span<const KmsConnector> connectors,
                                                std::string_view name) noexcept {
  for (std::size_t i = 0; i < connectors.size(); ++i) {
    if (name.empty() ? connectors[i].connected : connectors[i].name == name) return i;
  }
  return {};
}

std::string name_of(const KmsMode& mode) {
  char text[64];
  std::snprintf(text, sizeof text, "%dx%d@%.2f", mode.width, mode.height, rate_of(mode));
  return text;
}

}  // namespace cupola
