// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <apps/manual/completion.hpp>

namespace mapjoin::apps::manual {
namespace {

constexpr const char* kHead = R"(# bash completion of mapjoin; made from its options when it was built
_mapjoin() {
  local current=${COMP_WORDS[COMP_CWORD]} previous=${COMP_WORDS[COMP_CWORD - 1]} words=
  COMPREPLY=()
)";

constexpr const char* kFoot = R"(  COMPREPLY=($(compgen -W "$words" -- "$current"))
}
complete -F _mapjoin mapjoin
)";

std::string all_names(const Command& command) {
  std::vector<std::string> names;
  for (const Group& group : command.groups) {
    for (const Parameter& option : group.options) names.insert(names.end(), option.names.begin(), option.names.end());
  }
  return fmt::format("{}", fmt::join(names, " "));
}

/// What may follow an option that takes a value; nothing is offered for numbers.
std::string value_of(const Parameter& option) {
  if (is_folder(option)) return "compopt -o dirnames; return";
  if (option.is_path) return "compopt -o default; return";
  const auto words = choices(option);
  return words.empty() ? "return" : fmt::format("words=\"{}\"", fmt::join(words, " "));
}

std::string values_of(const Command& command) {
  std::string text;
  for (const Group& group : command.groups) {
    for (const Parameter& option : group.options) {
      if (option.kind.empty()) continue;
      for (const std::string& name : option.names)
        text += fmt::format("    {}:{}) {} ;;\n", command.name, name, value_of(option));
    }
  }
  return text;
}

/// Where a word begins that is no value: an option, or else an argument.
std::string words_of(const Command& command) {
  const std::string options = fmt::format("words=\"{}\"", all_names(command));
  if (command.arguments.empty()) return fmt::format("    {}:*) {} ;;\n", command.name, options);
  return fmt::format(
      "    {}:*)\n"
      "      if [[ $current != -* ]]; then compopt -o default; return; fi\n"
      "      {}\n"
      "      ;;\n",
      command.name, options);
}

}  // namespace

std::string bash_completion(const Command& mapjoin, const std::vector<Command>& all) {
  std::vector<std::string> names;
  for (const Command& command : all) names.push_back(command.name);
  std::string text = kHead;
  text += fmt::format(
      "  if ((COMP_CWORD == 1)); then\n"
      "    COMPREPLY=($(compgen -W \"{} {}\" -- \"$current\"))\n"
      "    return\n"
      "  fi\n"
      "  case ${{COMP_WORDS[1]}}:$previous in\n",
      fmt::join(names, " "), all_names(mapjoin));
  for (const Command& command : all) text += values_of(command) + words_of(command);
  return text + "  esac\n" + kFoot;
}

}  // namespace mapjoin::apps::manual
