// The virtual screen from the outside: its plug, and its pixels.
// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <vector>

namespace cupola {

// Forces the connector Virtual-1 on or off.
void plug_vkms(bool in);

// The card's descriptor that this process opened first, as only its owner may ask for what is on the screen;
// -1: there is none.
int vkms_descriptor();

// Asks for another picture behind the owner's back; errno's number, or 0.
int flip_vkms(std::uint32_t framebuffer);

// What the screen shows now, word by word, through the write-back connector; empty, with a failed
// expectation, where that fails.
std::vector<std::uint32_t> vkms_screen(int width, int height);

}  // namespace cupola
