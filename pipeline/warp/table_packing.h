// The bytes of a table file made small, for rigs whose tables are `compact`: a Zstandard file (RFC 8878) of
// frames that are packed and unpacked side by side. `zstd -d` gives back the table file.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <optional>
#include <span>
#include <vector>

#include "pipeline/frame/mapped_bytes.h"
#include "pipeline/parallel/worker_pool.h"

namespace cupola {

inline constexpr std::size_t kPackedPart = std::size_t{2} << 20;  // bytes of the table in a frame

// The same bytes for any number of threads.
std::vector<std::byte> pack_table(std::span<const std::byte> file, WorkerPool& pool);

// Nothing unless `packed` is whole and what pack_table() would write of at most `most_bytes`. Whatever the
// bytes are, no more memory than that is taken.
std::optional<MappedBytes> unpack_table(std::span<const std::byte> packed, std::size_t most_bytes,
                                        WorkerPool& pool);

}  // namespace cupola
