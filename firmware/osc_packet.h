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

// The messages in the packet's order, those of bundles too. A bundle in another one that is to count at once
// counts with that; one that is to count before it is ill-formed. The time 0, of senders without a clock, is
// at once too. Values are of the types i, h, f, d, s, S, T, F and I. Throws InputError: nothing of an
// ill-formed packet counts.
std::vector<OscMessage> read_osc_packet(std::span<const std::uint8_t> packet);

// Without its time. Whole numbers as i, or h where they are larger, others as f. Throws Failure.
std::string osc_packet(const OscMessage& message);

}  // namespace cupola
