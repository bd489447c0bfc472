// cupola status: what a player on this machine or another is doing.
// SPDX-License-Identifier: MIT
#include <cstdio>

#include "firmware/command.h"
#include "firmware/control_server.h"
#include "pipeline/frame/error.h"

namespace cupola {
namespace {

class StatusCommand final : public Command {
 public:
  explicit StatusCommand(CLI::App& program)
      : Command(program, "status", "What a player that was started with --http is doing",
                "  cupola status\n"
                "  cupola status --http 192.168.1.20:8080 --token-file token --json\n") {
    options()
        .add_option("--http", http_, "Where it listens; 127.0.0.1:8080 unless given")
        ->type_name("ADDRESS:PORT");
    options()
        .add_option("--token-file", token_file_, "The file whose first line is its token")
        ->type_name("FILE");
    options().add_flag("--json", json_, "As JSON");
  }

  int run() override {
    ControlAddress address;
    try {
      address = parse_control_address(http_);
    } catch (const InputError& error) {
      throw InputError(std::string("--http ") + error.what());
    }
    const std::string token = token_file_.empty() ? "" : read_token(token_file_);
    const std::string status = ask_status(address, token);
    std::fputs((json_ ? status : status_text(status)).c_str(), stdout);
    return 0;
  }

 private:
  std::string http_ = "127.0.0.1:8080";
  std::string token_file_;
  bool json_ = false;
};

}  // namespace

std::unique_ptr<Command> make_status_command(CLI::App& program) {
  return std::make_unique<StatusCommand>(program);
}

}  // namespace cupola
