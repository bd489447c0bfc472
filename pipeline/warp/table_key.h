// What a warp table is a function of, as numbers.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <string>
#include <vector>

#include "pipeline/optics/rig.h"

namespace cupola {

// Every value of the rig that bears on its table, doubles as their bits; no names, no paths. Two rigs have
// the same table if, and for all that is known only if, these are the same.
using TableKey = std::vector<std::uint64_t>;
TableKey table_key(const Rig& rig);

// Sixteen hexadecimal digits made of it.
std::string hash_of(const TableKey& key);

}  // namespace cupola
