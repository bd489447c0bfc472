// OSC packets of untrusted bytes: messages, and bundles of them.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <span>
#include <string>
#include <vector>

#include "firmware/osc_command.h"

namespace cupola {

constexpr std::size_t kLargestOscPacket = 4096;  // bytes

// The messages in the packet's order, those of bundles too, whose times are not heeded: commands count from
// the next frame on. Values are of the types i, h, f, d, s, S, T, F and I. Throws InputError: nothing of an
// ill-formed packet counts.
std::vector<OscMessage> read_osc_packet(std::span<const std::uint8_t> packet);

// Whole numbers as i, or h where they are larger, others as f. Throws Failure.
std::string osc_packet(const OscMessage& message);

}  // namespace cupola
