// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <apps/manual/completion.hpp>

namespace mapjoin::apps::manual {
namespace {

constexpr const char* kHead = R"(#compdef mapjoin
# zsh completion of mapjoin; made from its options when it was built
local context state state_descr line
typeset -A opt_args
)";

/// Within single quotes of the shell, with a backslash before each of `marks`.
std::string escaped(const std::string& text, std::string_view marks) {
  std::string out;
  for (const char c : text) {
    if (marks.find(c) != std::string_view::npos) out += '\\';
    out += c == '\'' ? "'\\''" : std::string(1, c);
  }
  return out;
}

/// What an option's value is called and chosen from, as _arguments takes it.
std::string value_of(const Parameter& option) {
  if (option.kind.empty()) return "";
  std::string action = " ";
  if (is_folder(option)) {
    action = "_files -/";
  } else if (option.is_path) {
    action = "_files";
  } else if (const auto words = choices(option); !words.empty()) {
    action = fmt::format("({})", fmt::join(words, " "));
  }
  return fmt::format(":{}:{}", escaped(option.kind, ":\\"), action);
}

/// '(-o --output)'{-o,--output}'[help]:DIR:_files -/', a line of its own.
std::string specification(const Parameter& option) {
  const std::string rest = fmt::format("'[{}]{}'", escaped(option.help, "[]\\"), value_of(option));
  const std::string names = option.names.size() == 1
                                ? "'" + option.names.front() + "'"
                                : fmt::format("'({})'{{{}}}", fmt::join(option.names, " "), fmt::join(option.names, ","));
  return fmt::format(" \\\n    {}{}", names, rest);
}

std::string specifications(const Command& command) {
  std::string text;
  for (const Group& group : command.groups) {
    for (const Parameter& option : group.options) text += specification(option);
  }
  for (const Parameter& argument : command.arguments) {
    text += fmt::format(" \\\n    '{}:{}:_files'", argument.is_repeated ? "*" : "", escaped(argument.names.front(), ":\\"));
  }
  return text;
}

}  // namespace

std::string zsh_completion(const Command& mapjoin, const std::vector<Command>& all) {
  std::string text = kHead;
  text +=
      "_arguments -C" + specifications(mapjoin) + " \\\n    '1:command:->command' \\\n    '*::argument:->argument' && return\n";
  text += "case $state in\n  command)\n    local -a commands=(\n";
  for (const Command& command : all) {
    text += fmt::format("      '{}:{}'\n", command.name, escaped(command.description, ":\\"));
  }
  text += "    )\n    _describe -t commands command commands\n    ;;\n  argument)\n    case $words[1] in\n";
  for (const Command& command : all) {
    text += fmt::format("  {})\n  _arguments{}\n  ;;\n", command.name, specifications(command));
  }
  return text + "    esac\n    ;;\nesac\n";
}

}  // namespace mapjoin::apps::manual
