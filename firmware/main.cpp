// The program `cupola`: finds the command, runs it, turns what went wrong into one line and an exit code.
// SPDX-License-Identifier: MIT
#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <exception>
#include <memory>
#include <new>
#include <string>
#include <vector>

#include "firmware/command.h"
#include "firmware/interrupt.h"
#include "pipeline/frame/error.h"
#include "pipeline/settings/settings.h"

namespace {

constexpr int kFailed = 1;
constexpr int kWrongInput = 2;

int complain(std::string message, int code) {
  std::replace(message.begin(), message.end(), '\n', ' ');
  std::fprintf(stderr, "%s\n", message.c_str());
  return code;
}

int run(int argc, char** argv) {
  CLI::App program("Cupola plays and renders dome projections", "cupola");
  program.set_version_flag("--version", "cupola " CUPOLA_VERSION);
  program.require_subcommand(1);
  program.footer("cupola COMMAND --help shows a command's options, with examples.");
  std::vector<std::unique_ptr<cupola::Command>> commands;
  commands.push_back(cupola::make_warp_command(program));
  commands.push_back(cupola::make_render_command(program));
  commands.push_back(cupola::make_play_command(program));
  commands.push_back(cupola::make_table_command(program));
  commands.push_back(cupola::make_check_command(program));
  commands.push_back(cupola::make_calibrate_command(program));
  commands.push_back(cupola::make_devices_command(program));
  commands.push_back(cupola::make_status_command(program));
  commands.push_back(cupola::make_bench_command(program));
  std::vector<std::string> names;
  for (const CLI::App* command : program.get_subcommands([](CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  if (argc > 1 && argv[1][0] != '-' && std::find(names.begin(), names.end(), argv[1]) == names.end()) {
    const std::vector<std::string_view> known(names.begin(), names.end());
    const std::string_view nearest = cupola::nearest_name(argv[1], known);
    return complain(
        std::string("cupola ") + argv[1] + ": no such command; " +
            (nearest.empty() ? "see cupola --help" : "did you mean " + std::string(nearest) + "?"),
        kWrongInput);
  }
  try {
    program.parse(argc, argv);
  } catch (const CLI::Success& help) {
    return program.exit(help);
  } catch (const CLI::ParseError& error) {
    return complain(std::string("cupola: ") + error.what() + "; see cupola --help", kWrongInput);
  }
  for (const auto& command : commands) {
    if (command->chosen()) return command->run();
  }
  return kWrongInput;
}

}  // namespace

int main(int argc, char** argv) {
  cupola::catch_interrupts();
  try {
    return run(argc, argv);
  } catch (const cupola::InputError& error) {
    return complain(error.what(), kWrongInput);
  } catch (const std::bad_alloc&) {
    return complain("cupola: there is not enough memory", kFailed);
  } catch (const std::exception& error) {
    return complain(error.what(), kFailed);
  }
}
