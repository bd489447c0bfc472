// cupola devices: what there is to put into a rig file.
// SPDX-License-Identifier: MIT
#include <fmt/format.h>

#include "firmware/command.h"
#include "firmware/device_list.h"

namespace cupola {
namespace {

class DevicesCommand final : public Command {
 public:
  explicit DevicesCommand(CLI::App& program)
      : Command(program, "devices", "List cameras, GPIO lines, displays and offscreen GL",
                "  cupola devices\n"
                "  cupola devices --json\n") {
    options().add_flag("--json", json_, "One JSON array instead of a table");
  }

  int run() override {
    const std::vector<FoundDevice> devices = find_devices();
    fmt::print("{}", json_ ? json_of(devices) : table_of(devices));
    return 0;
  }

 private:
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_devices_command(CLI::App& program) {
  return std::make_unique<DevicesCommand>(program);
}

}  // namespace cupola
