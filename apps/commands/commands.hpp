// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line: all subcommands, each declared in a file of its own, as main() parses them.

#include <apps/commands/subcommand.hpp>
#include <memory>
#include <vector>

namespace mapjoin::apps {

void declare_run(Subcommand& command);
void declare_build(Subcommand& command);
void declare_join(Subcommand& command);
void declare_solve(Subcommand& command);
void declare_compare(Subcommand& command);
void declare_basin(Subcommand& command);
void declare_convexity(Subcommand& command);
void declare_plot(Subcommand& command);
void declare_simulate(Subcommand& command);
void declare_info(Subcommand& command);
void declare_check(Subcommand& command);
void declare_convert(Subcommand& command);

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

CommandLine command_line();

}  // namespace mapjoin::apps
