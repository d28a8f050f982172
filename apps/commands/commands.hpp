// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line: all subcommands, each declared in a file of its own, as main() parses them.

#include <apps/commands/subcommand.hpp>
#include <memory>
#include <string>
#include <vector>

namespace mapjoin::apps {

std::unique_ptr<Subcommand> run_command(CLI::App& app);
std::unique_ptr<Subcommand> build_command(CLI::App& app);
std::unique_ptr<Subcommand> join_command(CLI::App& app);
std::unique_ptr<Subcommand> solve_command(CLI::App& app);
std::unique_ptr<Subcommand> compare_command(CLI::App& app);
std::unique_ptr<Subcommand> basin_command(CLI::App& app);
std::unique_ptr<Subcommand> convexity_command(CLI::App& app);
std::unique_ptr<Subcommand> plot_command(CLI::App& app);
std::unique_ptr<Subcommand> simulate_command(CLI::App& app);
std::unique_ptr<Subcommand> info_command(CLI::App& app);
std::unique_ptr<Subcommand> check_command(CLI::App& app);
std::unique_ptr<Subcommand> convert_command(CLI::App& app);

/// In the order of the help.
inline std::vector<std::unique_ptr<Subcommand>> all_commands(CLI::App& app) {
  std::vector<std::unique_ptr<Subcommand>> commands;
  for (const auto make : {run_command, build_command, join_command, solve_command, compare_command, basin_command,
                          convexity_command, plot_command, simulate_command, info_command, check_command, convert_command})
    commands.push_back(make(app));
  return commands;
}

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

CommandLine command_line();

}  // namespace mapjoin::apps
