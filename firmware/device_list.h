// Everything of this machine that a rig could use, and why what cannot be used cannot.
// SPDX-License-Identifier: MIT
#pragma once

#include <string>
#include <vector>

namespace cupola {

struct FoundDevice {
  std::string kind;     // "camera", "gpio", "display", "gl"
  std::string driver;   // "v4l2", "libcamera", "libgpiod", "kms", "window", "egl", ...
  std::string name;     // what a rig file calls it by
  std::string details;  // a line: card, bus, sizes, lines
  std::string problem;  // why it cannot be used; empty when it can
};

// Asks every driver. One without any device, or that is not built in, yields a row without a name that says
// so.
std::vector<FoundDevice> find_devices();

// For people, one row a device; and one JSON array.
std::string table_of(const std::vector<FoundDevice>& devices);
std::string json_of(const std::vector<FoundDevice>& devices);

}  // namespace cupola
