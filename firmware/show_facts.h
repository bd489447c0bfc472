// What those who control a show know of it, which does not change while it plays.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace cupola {

struct ShowFacts {
  std::string show;                  // its name
  std::vector<std::string> cues;     // their names
  std::vector<std::string> views;    // their names, in the rig's order
  std::vector<bool> finished;        // one a cue: its pictures are the dome's, and no view's
  std::vector<bool> live;            // one a cue
  std::vector<std::string> cameras;  // the views they are of, in the rig file's order; none: no cue is live
  std::string display;               // as --display names it
};

}  // namespace cupola
