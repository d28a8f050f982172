// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <apps/commands/commands.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <mapjoin/version.hpp>
#include <sstream>
#include <utility>

namespace mapjoin::apps {
namespace {

constexpr const char* kDescription =
    "Builds large maps from many small ones: splits a log of odometry and feature observations into local maps, joins them, "
    "and polishes the result to the optimum of the whole log.";

constexpr std::size_t kWidth = 120;      ///< Of the help, in characters.
constexpr std::size_t kNameColumn = 36;  ///< Of it, for the names of options.

/// Broken between words into lines of at most `width` characters, where no word is longer.
std::string wrapped(const std::string& text, std::size_t width) {
  std::istringstream words(text);
  std::string lines;
  std::size_t length = 0;
  for (std::string word; words >> word; length += word.size()) {
    if (length > 0 && length + 1 + word.size() > width) {
      lines += '\n';
      length = 0;
    } else if (length > 0) {
      lines += ' ';
      ++length;
    }
    lines += word;
  }
  return lines;
}

/// CLI11's, with lines that end between words, one blank line where it leaves two, and names as help2man knows them: "-o,
/// --output", two spaces before the description.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
    boost::replace_all(help, " \n", "\n");
    boost::replace_all(help, "\n\n\n", "\n\n");
    return help;
  }
  std::string make_description(const CLI::App* app) const override { return wrapped(app->get_description(), kWidth) + "\n"; }
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    std::string name = CLI::Formatter::make_option_name(option, is_positional);
    if (const std::size_t comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
    return name;
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    return CLI::Formatter::make_option_opts(option) + " ";
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped(option->get_description(), kWidth - kNameColumn);
  }
};

std::string footer() {
  std::string exit_codes = "Exit codes:";
  for (const auto& [code, meaning] : kExitCodes) exit_codes += fmt::format(" {} {},", static_cast<int>(code), meaning);
  exit_codes.back() = '.';
  return "`mapjoin COMMAND --help` lists a command's options, with examples.\n" + wrapped(exit_codes, kWidth);
}

}  // namespace

CommandLine command_line() {
  CommandLine line{std::make_shared<CLI::App>(kDescription, "mapjoin"), {}};
  CLI::App& app = *line.app;
  app.formatter(std::make_shared<HelpFormatter>());
  app.get_formatter()->column_width(kNameColumn);
  app.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app.get_formatter()->label("Positionals", "Arguments");
  app.set_help_flag("-h,--help", "This text");
  app.set_version_flag("--version", fmt::format("mapjoin {}", kVersion), "The version");
  app.require_subcommand(1);
  app.footer(footer());
  line.commands = all_commands(app);
  return line;
}

}  // namespace mapjoin::apps
