// Picks are kept as JSON, for people to read too.
// SPDX-License-Identifier: MIT
#include "firmware/held_budget.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cstdio>
#include <fstream>
#include <nlohmann/json.hpp>

#include "firmware/dial_trial.h"
#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/checksum.h"
#include "pipeline/frame/error.h"
#include "pipeline/warp/table_key.h"

namespace cupola {
namespace {

constexpr int kVersion = 1;  // to rise with whatever makes old picks wrong

// As the kernel names it; on machines without that line picks are told apart by instruction set and threads.
std::string processor() {
  std::ifstream file("/proc/cpuinfo");
  for (std::string line; std::getline(file, line);) {
    if (line.starts_with("model name") || line.starts_with("CPU part"))
      return line.substr(line.find(':') + 1);
  }
  return {};
}

std::filesystem::path file_of(const std::filesystem::path& folder, const std::string& key) {
  return folder / fmt::format("{:016x}.pick", checksum(std::as_bytes(std::span(key))));
}

nlohmann::ordered_json as_json(const DialResult& result) {
  return {{"filter", result.name},
          {"error_rms", result.error},
          {"ms", result.milliseconds},
          {"guessed", result.guessed}};
}

DialResult as_result(const nlohmann::json& json) {
  return {json.at("filter"), json.at("error_rms"), json.at("ms"), json.at("guessed")};
}

const DialSetting* find_setting(std::string_view name, bool deep) {
  const auto settings = dial_settings(deep);
  const auto found = std::ranges::find(settings, name, &DialSetting::name);
  return found == settings.end() ? nullptr : &*found;
}

}  // namespace

std::optional<DialPick> recalled_pick(const std::filesystem::path& folder, const std::string& key) {
  if (folder.empty()) return std::nullopt;
  std::ifstream file(file_of(folder, key));
  const nlohmann::json json = nlohmann::json::parse(file, nullptr, false);
  try {
    if (json.at("key") != key) return std::nullopt;
    DialPick pick{as_result(json.at("picked")), json.at("holds"), {}};
    for (const nlohmann::json& result : json.at("given_up")) pick.given_up.push_back(as_result(result));
    return pick;
  } catch (const nlohmann::json::exception&) {
    return std::nullopt;  // no file, or no pick in it
  }
}

void keep_pick(const std::filesystem::path& folder, const std::string& key, const DialPick& pick) {
  if (folder.empty()) return;
  nlohmann::ordered_json json = {{"key", key},
                                 {"picked", as_json(pick.picked)},
                                 {"holds", pick.holds},
                                 {"given_up", nlohmann::json::array()}};
  for (const DialResult& result : pick.given_up) json["given_up"].push_back(as_json(result));
  try {
    std::error_code ignored;  // AtomicFile says what is wrong
    std::filesystem::create_directories(folder, ignored);
    AtomicFile file(file_of(folder, key));
    file.write(json.dump(2) + "\n");
    file.commit();
  } catch (const Failure& failure) {
    fmt::print(stderr, "cupola: the pick is not kept: {}\n", failure.what());
  }
}

std::string pick_key(const Rig& rig, bool deep, Cpu cpu, int threads) {
  return fmt::format("{}; budget {:g} ms; {} bits;{}; {}; {} threads; rig {:x}", kVersion, *rig.budget_ms,
                     deep ? 16 : 8, processor(), name(cpu), threads, fmt::join(table_key(rig), " "));
}

void hold_budget(Rig& rig, bool deep, Cpu cpu, int threads, const std::filesystem::path& folder,
                 const Measure& measure) {
  if (!rig.budget_ms) return;
  rig.filter = FilterSettings();  // part of the key
  const std::string key = pick_key(rig, deep, cpu, threads);
  std::optional<DialPick> pick = recalled_pick(folder, key);
  const bool recalled = pick && find_setting(pick->picked.name, deep);
  if (!recalled) {
    pick = measure();
    keep_pick(folder, key, *pick);
  }
  rig.filter = find_setting(pick->picked.name, deep)->filter;
  fmt::print(stderr, "cupola: {}: {}{}\n", rig.file.string(), describe(*pick, *rig.budget_ms),
             recalled ? "; as measured before" : "");
}

void hold_budget(Rig& rig, bool deep, Cpu cpu, WorkerPool& pool, TableCache* cache) {
  hold_budget(rig, deep, cpu, pool.threads(), cache ? cache->folder() : std::filesystem::path(), [&] {
    fmt::print(stderr, "cupola: {}: measuring filters for budget_ms = {:g}\n", rig.file.string(),
               *rig.budget_ms);
    MonotonicClock clock;
    MachineTrial trial(rig, deep, cpu, pool, cache, clock);
    return turn_dial(*rig.budget_ms, dial_settings(deep), trial);
  });
}

}  // namespace cupola
