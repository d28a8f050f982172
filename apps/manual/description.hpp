// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a command says of itself, read off its declaration: all that manual pages and completion are made from.

#include <string>
#include <vector>

namespace CLI {
class App;
}

namespace mapjoin::apps::manual {

struct Parameter {
  std::vector<std::string> names;  ///< "-o", "--output"; of an argument the one that the help calls it by.
  std::string kind;                ///< Of its value; empty where it takes none, and for arguments.
  std::string help;
  bool is_required = false;
  bool is_repeated = false;
  bool is_path = false;
};

struct Group {
  std::string heading;
  std::vector<Parameter> options;
};

struct Command {
  std::string name;
  std::string description;
  std::vector<Parameter> arguments;
  std::vector<Group> groups;
  std::vector<std::string> examples;
  std::vector<std::string> notes;  ///< What the help says below the examples.
};

/// Of a subcommand, or of the whole command, which has no examples.
Command describe(CLI::App& app);

/// The words among which a value is chosen: of "tree|batch" both, of "N|auto" the second.
std::vector<std::string> choices(const Parameter& option);
/// Its value is a folder.
bool is_folder(const Parameter& option);

}  // namespace mapjoin::apps::manual
