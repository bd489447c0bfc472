// What a table's kernels load of each view: the box that a camera must send.
// SPDX-License-Identifier: MIT
#pragma once

#include <vector>

#include "pipeline/optics/view.h"
#include "pipeline/warp/warp_table.h"

namespace cupola {

// The smallest box of each of the table's views that holds every texel loaded for any of the frame's mirror
// images, those without a weight included: windows are loaded whole, and rows in pairs. Empty: the view is
// not looked at.
std::vector<TexelBox> texels_read(const WarpTable& table);

// The smallest box that holds both; an empty one counts for nothing.
TexelBox box_around(const TexelBox& a, const TexelBox& b);

// The smallest box of even places around the box, within a view of that size, whose own end may be odd:
// cameras crop by whole texels of chroma.
TexelBox even_box(const TexelBox& box, Size view);

}  // namespace cupola
