// Changes of the screen that take effect together, at a flip; nothing here allocates or waits.
// SPDX-License-Identifier: MIT
#pragma once

#include <chrono>
#include <cstdint>

#include "hal/display/kms_buffer.h"
#include "hal/display/kms_device.h"

namespace cupola {

// All return errno's number, 0: taken. A flip and a mode announce their flip, once, to take_flip() by
// `number`. Only the picture.
int commit_flip(const KmsFile& card, const KmsPipe& pipe, const KmsBuffer& buffer,
                std::uint64_t number) noexcept;
// Whether that would be taken; nothing changes.
int test_flip(const KmsFile& card, const KmsPipe& pipe, const KmsBuffer& buffer) noexcept;
// The mode, of which `blob` is the kernel's copy, with the picture; the buffer has the mode's size.
int commit_mode(const KmsFile& card, const KmsPipe& pipe, std::uint32_t blob, const KmsBuffer& buffer,
                std::uint64_t number) noexcept;
int commit_off(const KmsFile& card, const KmsPipe& pipe) noexcept;

// Events that the card has ready: true when the flip of that number was among them, with its time on
// CLOCK_MONOTONIC.
bool take_flip(const KmsFile& card, std::uint64_t number, std::chrono::nanoseconds& flipped_at) noexcept;

}  // namespace cupola
