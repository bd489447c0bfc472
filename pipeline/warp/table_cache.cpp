// Finding, keeping and making room for tables.
// SPDX-License-Identifier: MIT
#include "pipeline/warp/table_cache.h"

#include <algorithm>
#include <cstdlib>
#include <string_view>
#include <vector>

#include "pipeline/frame/atomic_file.h"
#include "pipeline/frame/error.h"
#include "pipeline/warp/table_build.h"
#include "pipeline/warp/table_file.h"
#include "pipeline/warp/table_key.h"
#include "pipeline/warp/table_packing.h"

namespace cupola {
namespace fs = std::filesystem;
namespace {

constexpr std::string_view kEnding = ".table";
constexpr std::string_view kPackedEnding = ".table.zst";

// Files of the cache, and what writers that were killed have left.
bool is_ours(const fs::path& file) {
  return file.filename().string().find(kEnding) != std::string::npos;
}

std::string_view variable(const char* name) {
  const char* value = std::getenv(name);
  return value == nullptr ? "" : value;
}

}  // namespace

WarpTable TableCache::table(const Rig& rig, WorkerPool& pool) {
  if (folder_.empty()) {
    ++built_;
    return build_warp_table(rig, pool);
  }
  fs::path file = folder_ / hash_of(table_key(rig));
  file += rig.filter.table == TableForm::kCompact ? kPackedEnding : kEnding;
  MappedBytes memory = stored(rig, file, pool);
  if (auto found = read_table(memory.bytes(), rig, pool)) {
    found->memory = std::move(memory);
    ++found_;
    std::error_code ignored;
    fs::last_write_time(file, fs::file_time_type::clock::now(), ignored);  // used just now
    return std::move(*found);
  }
  WarpTable table = build_warp_table(rig, pool);
  ++built_;
  keep(rig, table, file, pool);
  return table;
}

MappedBytes TableCache::stored(const Rig& rig, const fs::path& file, WorkerPool& pool) const {
  MappedBytes memory = MappedBytes::of_file(file);
  if (rig.filter.table != TableForm::kCompact) return memory;
  return unpack_table(memory.bytes(), static_cast<std::size_t>(most_bytes_), pool).value_or(MappedBytes());
}

void TableCache::keep(const Rig& rig, const WarpTable& table, const fs::path& file, WorkerPool& pool) {
  if (static_cast<std::int64_t>(table.memory.bytes().size()) > most_bytes_) return;
  try {
    std::error_code ignored;  // AtomicFile says what is wrong
    fs::create_directories(folder_, ignored);
    AtomicFile whole(file);
    if (rig.filter.table == TableForm::kCompact) {
      whole.write(pack_table(table.memory.bytes(), pool));
    } else {
      whole.write(table.memory.bytes());
    }
    whole.commit();
    make_room(file);
  } catch (const Failure& failure) {
    if (trouble_.empty()) trouble_ = failure.what();
  }
}

void TableCache::make_room(const fs::path& kept) const {
  struct Entry {
    fs::file_time_type used;
    std::int64_t bytes;
    fs::path file;
  };
  std::vector<Entry> entries;
  std::int64_t sum = 0;
  std::error_code error;
  for (fs::directory_iterator at(folder_, error), end; !error && at != end; at.increment(error)) {
    std::error_code gone;  // another program may be making room too
    if (!is_ours(at->path()) || !at->is_regular_file(gone)) continue;
    const auto bytes = static_cast<std::int64_t>(at->file_size(gone));
    const fs::file_time_type used = gone ? fs::file_time_type() : at->last_write_time(gone);
    if (gone) continue;
    sum += bytes;
    if (at->path() != kept) entries.push_back({used, bytes, at->path()});
  }
  std::sort(entries.begin(), entries.end(), [](const Entry& a, const Entry& b) { return a.used < b.used; });
  for (const Entry& entry : entries) {
    if (sum <= most_bytes_) return;
    if (fs::remove(entry.file, error)) sum -= entry.bytes;
  }
}

fs::path cache_folder() {
  const std::string_view ours = variable("CUPOLA_CACHE");
  if (ours == "off") return {};
  if (!ours.empty()) return ours;
  const fs::path caches = variable("XDG_CACHE_HOME");
  if (caches.is_absolute()) return caches / "cupola";  // the XDG specification has others ignored
  const fs::path home = variable("HOME");
  return home.is_absolute() ? home / ".cache" / "cupola" : fs::path();
}

}  // namespace cupola
