// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/exit_code.hpp>
#include <apps/manual/man_page.hpp>
#include <mapjoin/version.hpp>

namespace mapjoin::apps::manual {
namespace {

/// As troff shows it: its own marks are escaped, and every hyphen is one that can be pasted.
std::string escaped(const std::string& text) {
  std::string out;
  for (const char c : text) {
    if (c == '\\') {
      out += "\\e";
    } else if (c == '-') {
      out += "\\-";
    } else {
      out += c;
    }
  }
  return out.starts_with('.') || out.starts_with('\'') ? fmt::format("\\&{}", out) : out;
}

std::string upper(std::string text) {
  std::transform(text.begin(), text.end(), text.begin(), [](unsigned char c) { return static_cast<char>(std::toupper(c)); });
  return text;
}

std::string bold(const std::string& text) {
  return fmt::format("\\fB{}\\fR", escaped(text));
}

std::string italic(const std::string& text) {
  return fmt::format("\\fI{}\\fR", escaped(text));
}

std::string head(const std::string& title, const std::string& name, const std::string& description) {
  return fmt::format(".TH {} 1 \"\" \"mapjoin {}\" \"User Commands\"\n.SH NAME\n{} \\- {}\n", upper(title), kVersion,
                     escaped(name), escaped(description));
}

std::string section(const std::string& heading) {
  return fmt::format(".SH {}\n", upper(heading));
}

/// What it is called, in bold, with the kind of its value in italics.
std::string term(const Parameter& option) {
  std::vector<std::string> names;
  for (const std::string& name : option.names) names.push_back(bold(name));
  return fmt::format("{}{}", fmt::join(names, ", "), option.kind.empty() ? "" : fmt::format(" {}", italic(option.kind)));
}

std::string tagged(const std::string& tag, const std::string& text) {
  return ".TP\n" + tag + "\n" + text + "\n";
}

std::string options_of(const Command& command) {
  std::string text;
  for (const Group& group : command.groups) {
    text += section(group.heading);
    for (const Parameter& option : group.options) {
      text += tagged(term(option), escaped(option.help) + (option.is_required ? " (required)" : ""));
    }
  }
  return text;
}

std::string exit_status() {
  std::string text = section("Exit status");
  for (const auto& [code, meaning] : kExitCodes) {
    text += tagged(bold(std::to_string(static_cast<int>(code))), escaped(std::string(meaning)));
  }
  return text;
}

std::string see_also(const std::vector<Command>& all, const std::string& but) {
  std::vector<std::string> pages;
  if (but != "mapjoin") pages.push_back(bold("mapjoin") + "(1)");
  for (const Command& other : all) {
    if (other.name != but) pages.push_back(bold("mapjoin-" + other.name) + "(1)");
  }
  return fmt::format("{}{}\n", section("See also"), fmt::join(pages, ",\n"));
}

}  // namespace

std::string man_page(const Command& command, const std::vector<Command>& all) {
  const std::string name = "mapjoin-" + command.name;
  std::string text = head(name, name, command.description) + section("Synopsis");
  text += bold("mapjoin " + command.name) + " [" + italic("OPTIONS") + "]";
  for (const Parameter& argument : command.arguments) {
    text += fmt::format(" {}{}", italic(argument.names.front()), argument.is_repeated ? "..." : "");
  }
  text += "\n";
  if (!command.arguments.empty()) text += section("Arguments");
  for (const Parameter& argument : command.arguments) {
    text += tagged(italic(argument.names.front()), escaped(argument.help));
  }
  text += options_of(command);
  text += section("Examples") + ".EX\n";
  for (const std::string& example : command.examples) text += escaped(example) + "\n";
  text += ".EE\n";
  if (!command.notes.empty()) text += section("Notes");
  for (const std::string& note : command.notes) text += escaped(note) + "\n";
  return text + exit_status() + see_also(all, command.name);
}

std::string man_page_of_all(const Command& mapjoin, const std::vector<Command>& all) {
  std::string text = head("mapjoin", "mapjoin", "large maps from many small ones by submap joining");
  text += section("Synopsis") + bold("mapjoin") + " " + italic("COMMAND") + " [" + italic("OPTIONS") + "]\n";
  text += section("Description") + escaped(mapjoin.description) + "\n" + section("Commands");
  for (const Command& command : all) text += tagged(bold("mapjoin-" + command.name) + "(1)", escaped(command.description));
  return text + options_of(mapjoin) + exit_status() + see_also(all, "mapjoin");
}

}  // namespace mapjoin::apps::manual
