// From the most accurate setting down, until one holds the budget.
// SPDX-License-Identifier: MIT
#include "firmware/dial.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <utility>

namespace cupola {
namespace {

constexpr FilterSettings precise(FilterSettings filter) {
  filter.table = TableForm::kPrecise;
  return filter;
}

std::string in_words(const DialResult& result) {
  return fmt::format("{} ({}{:.3g} ms, error {:.2f} rms)", result.name, result.guessed ? "about " : "",
                     result.milliseconds, result.error);
}

}  // namespace

std::span<const DialSetting> dial_settings(bool deep) {
  // Tables only: on every machine with vectors they are cheaper than the other methods, and they skip what
  // did not change. Smaller or narrower Gaussians than the default were no cheaper.
  static const std::array<DialSetting, 6> kSettings = {{{"optimal", optimal_filter()},
                                                        {"robidoux", robidoux_filter()},
                                                        {"gaussian", default_gaussian()},
                                                        {"optimal, precise", precise(optimal_filter())},
                                                        {"robidoux, precise", precise(robidoux_filter())},
                                                        {"gaussian, precise", precise(default_gaussian())}}};
  return deep ? std::span(kSettings).last(3) : std::span(kSettings);
}

DialPick turn_dial(double budget_ms, std::span<const DialSetting> settings, DialTrial& trial) {
  struct Candidate {
    const DialSetting* setting;
    DialTrial::Sketch sketch;
  };
  std::vector<Candidate> candidates;
  for (const DialSetting& setting : settings) candidates.push_back({&setting, trial.sketch(setting.filter)});
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.sketch.error < b.sketch.error; });
  DialPick pick;
  for (const Candidate& at : candidates) {
    const bool hopeless = at.sketch.milliseconds > kHopelessBudgets * budget_ms;
    pick.picked = {std::string(at.setting->name), at.sketch.error, at.sketch.milliseconds, hopeless};
    if (!hopeless) pick.picked.milliseconds = trial.milliseconds(at.setting->filter);
    pick.holds = !hopeless && pick.picked.milliseconds <= budget_ms;
    if (pick.holds) return pick;
    pick.given_up.push_back(pick.picked);
  }
  // Guesses are low: one is believed only where nothing was measured.
  const auto cheapest = std::ranges::min_element(
      pick.given_up, {}, [](const DialResult& at) { return std::pair(at.guessed, at.milliseconds); });
  pick.picked = *cheapest;
  if (pick.picked.guessed) {
    const auto place = static_cast<std::size_t>(cheapest - pick.given_up.begin());
    pick.picked.milliseconds = trial.milliseconds(candidates[place].setting->filter);
    pick.picked.guessed = false;
    pick.holds = pick.picked.milliseconds <= budget_ms;  // the guess was too high
  }
  pick.given_up.erase(cheapest, pick.given_up.end());
  return pick;
}

std::string describe(const DialPick& pick, double budget_ms) {
  std::string line = pick.holds ? fmt::format("budget_ms = {:g}: {}", budget_ms, in_words(pick.picked))
                                : fmt::format("budget_ms = {:g} cannot be held: the cheapest filter is {}",
                                              budget_ms, in_words(pick.picked));
  for (std::size_t i = 0; i < pick.given_up.size(); ++i) {
    line += (i == 0 ? "; given up: " : ", ") + in_words(pick.given_up[i]);
  }
  return line;
}

}  // namespace cupola
