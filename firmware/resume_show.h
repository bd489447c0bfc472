// A show that goes on where a position file says.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>

#include "firmware/control_answers.h"
#include "firmware/control_link.h"
#include "firmware/show_frames.h"

namespace cupola {

// Before the first frame. What cannot be had is said in the link's log, and the show begins at its start; a
// file that is not there is not spoken of.
void resume_show(const std::string& file, ShowFrames& frames, const ShowFacts& facts, ControlLink& link);

}  // namespace cupola
