// From a rig with a budget to a rig with a filter: measured once on a machine, then remembered.
// SPDX-License-Identifier: MIT
#pragma once

#include <filesystem>
#include <functional>
#include <optional>
#include <string>

#include "firmware/dial.h"
#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/cpu.h"
#include "pipeline/warp/table_cache.h"

namespace cupola {

// Picks in a folder, one a file, beside the tables. The key is all that they depend on; it is in the file,
// and compared in full. A file that is damaged or of another key is as good as none.
std::optional<DialPick> recalled_pick(const std::filesystem::path& folder, const std::string& key);
// Trouble costs another measurement and nothing else.
void keep_pick(const std::filesystem::path& folder, const std::string& key, const DialPick& pick);

// The rig's geometry, budget and depth, this machine's processor, the instruction set and the threads.
std::string pick_key(const Rig& rig, bool deep, Cpu cpu, int threads);

// Where the rig has a budget, gives it the filter that holds it and says so on standard error; before the
// show, never in it. Views must have sizes. `measure` is asked where the folder of `cache` knows no pick.
using Measure = std::function<DialPick()>;
void hold_budget(Rig& rig, bool deep, Cpu cpu, WorkerPool& pool, TableCache* cache);
void hold_budget(Rig& rig, bool deep, Cpu cpu, int threads, const std::filesystem::path& folder,
                 const Measure& measure);

}  // namespace cupola
