// SPDX-License-Identifier: BSD-3-Clause
#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <algorithm>
#include <apps/manual/description.hpp>
#include <sstream>

namespace mapjoin::apps::manual {
namespace {

bool has_path(CLI::Option& option) {
  try {
    return option.get_validator("path") != nullptr;
  } catch (const CLI::OptionNotFound&) {
    return false;
  }
}

Parameter parameter_of(CLI::Option& option) {
  Parameter parameter;
  for (const std::string& name : option.get_snames()) parameter.names.push_back("-" + name);
  for (const std::string& name : option.get_lnames()) parameter.names.push_back("--" + name);
  if (option.get_positional()) parameter.names = {option.get_name(true)};
  if (option.get_items_expected_max() > 0 && !option.get_positional()) parameter.kind = option.get_type_name();
  parameter.help = option.get_description();
  parameter.is_required = option.get_required();
  parameter.is_repeated = option.get_positional() && option.get_items_expected_max() > 1;
  parameter.is_path = has_path(option);
  return parameter;
}

/// The indented lines below "Examples:", and the others.
void take_footer(const std::string& footer, Command& command) {
  std::istringstream lines(footer);
  for (std::string line; std::getline(lines, line);) {
    if (line.starts_with("  ")) {
      command.examples.push_back(line.substr(2));
    } else if (line != "Examples:") {
      command.notes.push_back(line);
    }
  }
}

bool is_word(const std::string& part) {
  return !part.empty() && part != "-" &&
         std::all_of(part.begin(), part.end(), [](unsigned char c) { return std::islower(c) || std::isdigit(c) || c == '-'; });
}

}  // namespace

Command describe(CLI::App& app) {
  Command command{app.get_name(), app.get_description(), {}, {}, {}, {}};
  take_footer(app.get_footer(), command);
  for (CLI::Option* option : app.get_options()) {
    if (option->get_positional()) {
      command.arguments.push_back(parameter_of(*option));
      continue;
    }
    const std::string& heading = option->get_group();
    const auto group =
        std::find_if(command.groups.begin(), command.groups.end(), [&](const Group& any) { return any.heading == heading; });
    Group& its = group != command.groups.end() ? *group : command.groups.emplace_back(Group{heading, {}});
    its.options.push_back(parameter_of(*option));
  }
  return command;
}

std::vector<std::string> choices(const Parameter& option) {
  std::istringstream parts(option.kind);
  std::vector<std::string> words;
  for (std::string part; std::getline(parts, part, '|');) {
    if (is_word(part)) words.push_back(part);
  }
  return words;
}

bool is_folder(const Parameter& option) {
  return option.is_path && option.kind == "DIR";
}

}  // namespace mapjoin::apps::manual
