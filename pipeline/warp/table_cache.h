// Warp tables kept in a folder, so that a rig's is built once.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <filesystem>
#include <string>

#include "pipeline/optics/rig.h"
#include "pipeline/parallel/worker_pool.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// A file is named by the hash of its rig's key. One that is stale or damaged is replaced; several programs
// may share a folder. Trouble with the folder costs time and nothing else.
class TableCache {
 public:
  static constexpr std::int64_t kMostBytes = std::int64_t{2} << 30;

  TableCache() = default;  // keeps nothing
  // The files used longest ago go when all together have more than `most_bytes`.
  explicit TableCache(std::filesystem::path folder, std::int64_t most_bytes = kMostBytes)
      : folder_(std::move(folder)), most_bytes_(most_bytes) {}

  // As build_warp_table.
  WarpTable table(const Rig& rig, WorkerPool& pool);

  const std::filesystem::path& folder() const { return folder_; }  // empty: nothing is kept
  int found() const { return found_; }                             // tables that were in the folder
  int built() const { return built_; }                             // those that were not
  // Why the first of them that could not be kept was not; empty when all were.
  const std::string& trouble() const { return trouble_; }

 private:
  MappedBytes stored(const Rig& rig, const std::filesystem::path& file, WorkerPool& pool) const;
  void keep(const Rig& rig, const WarpTable& table, const std::filesystem::path& file, WorkerPool& pool);
  void make_room(const std::filesystem::path& kept) const;

  std::filesystem::path folder_;
  std::int64_t most_bytes_ = kMostBytes;
  int found_ = 0;
  int built_ = 0;
  std::string trouble_;
};

// The folder that the environment says: none for CUPOLA_CACHE=off, that of CUPOLA_CACHE=DIR, otherwise
// $XDG_CACHE_HOME/cupola or ~/.cache/cupola; none without a home.
std::filesystem::path cache_folder();

}  // namespace cupola
