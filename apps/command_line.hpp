// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The command line as it is declared: what main() parses, and what the manual is made from.

#include <apps/subcommand.hpp>
#include <memory>
#include <string>
#include <vector>

namespace mapjoin::apps {

struct CommandLine {
  std::shared_ptr<CLI::App> app;
  std::vector<std::unique_ptr<Subcommand>> commands;  ///< In the order of the help.
};

CommandLine command_line();

/// Broken between words into lines of at most `width` characters, where no word is longer.
std::string wrapped(const std::string& text, std::size_t width);

}  // namespace mapjoin::apps
