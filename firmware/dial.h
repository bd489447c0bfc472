// The dial: of a few filters the most accurate one whose frame takes no longer than a budget.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "pipeline/optics/filter.h"

namespace cupola {

struct DialSetting {
  std::string_view name;
  FilterSettings filter;
};

// What there is to pick from. `deep`: faces of 16 bits, which have precise tables only.
std::span<const DialSetting> dial_settings(bool deep);

// What a setting costs and errs, found by trying.
class DialTrial {
 public:
  struct Sketch {
    double error = 0.0;         // root mean square against ground truth, 8-bit steps
    double milliseconds = 0.0;  // of a whole frame, guessed from a small one
  };
  virtual ~DialTrial() = default;
  virtual Sketch sketch(const FilterSettings& filter) = 0;
  // Of a whole frame, measured.
  virtual double milliseconds(const FilterSettings& filter) = 0;
};

struct DialResult {
  std::string name;
  double error = 0.0;
  double milliseconds = 0.0;
  bool guessed = false;  // the time is the sketch's
  friend bool operator==(const DialResult&, const DialResult&) = default;
};
struct DialPick {
  DialResult picked;
  bool holds = false;                // false: it is the cheapest there is, and over budget
  std::vector<DialResult> given_up;  // more accurate ones, the most accurate first
  friend bool operator==(const DialPick&, const DialPick&) = default;
};

// Sketches whose guess is over this many budgets are given up without a measurement, which would build their
// whole table: a small frame lies in the caches and takes up to half of a large one's time a pixel.
inline constexpr double kHopelessBudgets = 1.5;

DialPick turn_dial(double budget_ms, std::span<const DialSetting> settings, DialTrial& trial);

// One line: what was picked, what it costs and errs, and what was given up for it.
std::string describe(const DialPick& pick, double budget_ms);

}  // namespace cupola
