// What differs between a face and the one before, found by comparing: for sources that are not told.
// SPDX-License-Identifier: MIT
#pragma once

#include "pipeline/frame/changed_cells.h"
#include "pipeline/frame/image.h"
#include "pipeline/optics/needed_region.h"

namespace cupola {

// Adds to `changed` every cell in which a needed texel of `now` differs from `before`; maybe also one in
// which only other texels do. Both planar, of one format and size. A cell known to differ is read no further,
// so that a face of which everything changed costs little and only one that stands is read whole.
void add_changes(const Image& before, const Image& now, const NeededRegion& needed, ChangedCells& changed);

}  // namespace cupola
