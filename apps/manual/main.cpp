// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_manual FOLDER: writes manual pages (man1/), completion (bash/, zsh/) and a page of Markdown per command (commands/),
// all from the command line as it is declared. A tool of the build, not installed.

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <apps/command_line.hpp>
#include <apps/manual/completion.hpp>
#include <apps/manual/man_page.hpp>
#include <filesystem>
#include <fstream>
#include <iostream>

namespace mapjoin::apps::manual {
namespace {

void write(const std::filesystem::path& file, const std::string& text) {
  std::filesystem::create_directories(file.parent_path());
  std::ofstream stream(file);
  if (!(stream << text << std::flush)) throw std::runtime_error("cannot write " + file.string());
}

/// What `mapjoin NAME --help` prints.
std::string help_of(const std::string& name) {
  const CommandLine line = command_line();
  try {
    line.app->parse({"--help", name});  // CLI11 takes the words from last to first.
  } catch (const CLI::CallForHelp&) {
  }
  return line.app->help();
}

std::string page_of(const Command& command) {
  return fmt::format("# mapjoin {0}\n\n{1}.\n\n```console\n$ mapjoin {0} --help\n{2}```\n\n[The other commands](README.md)\n",
                     command.name, command.description, help_of(command.name));
}

std::string list_of(const std::vector<Command>& all) {
  std::string text = "# Commands\n\nEach page is what `--help` prints.\n\n| command | what it does |\n|---|---|\n";
  for (const Command& command : all) {
    text += fmt::format("| [`mapjoin {0}`]({0}.md) | {1} |\n", command.name, command.description);
  }
  return text;
}

void write_all(const std::filesystem::path& folder) {
  const CommandLine line = command_line();
  const Command mapjoin = describe(*line.app);
  std::vector<Command> all;
  for (CLI::App* command : line.app->get_subcommands([](CLI::App*) { return true; })) all.push_back(describe(*command));
  write(folder / "man1" / "mapjoin.1", man_page_of_all(mapjoin, all));
  write(folder / "bash" / "mapjoin", bash_completion(mapjoin, all));
  write(folder / "zsh" / "_mapjoin", zsh_completion(mapjoin, all));
  write(folder / "commands" / "README.md", list_of(all));
  for (const Command& command : all) {
    write(folder / "man1" / ("mapjoin-" + command.name + ".1"), man_page(command, all));
    write(folder / "commands" / (command.name + ".md"), page_of(command));
  }
}

}  // namespace
}  // namespace mapjoin::apps::manual

int main(int argc, char** argv) {
  try {
    if (argc != 2) throw std::runtime_error("one argument is required: the folder to write to");
    mapjoin::apps::manual::write_all(argv[1]);
  } catch (const std::exception& error) {
    std::cerr << "mapjoin_manual: " << error.what() << '\n';
    return 1;
  }
}
