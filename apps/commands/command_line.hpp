// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line as it is declared: what main() parses.

#include <apps/commands/subcommand.hpp>
#include <memory>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

CommandLine command_line();

}  // namespace mapjoin::apps
