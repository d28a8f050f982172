// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <CLI/Formatter.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/console.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <mapjoin/version.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

constexpr const char* kDescription =
    "Builds large maps from many small ones: splits a log of odometry and feature observations into local maps, joins them, "
    "and polishes the result to an optimum of the whole log.";

constexpr std::size_t kWidth = 120;      ///< Width of the help in characters.
constexpr std::size_t kNameColumn = 36;  ///< Part of it for the names of options.

std::string wrapped_lines(const std::string& text, std::size_t width) {
  return fmt::format("{}", fmt::join(wrapped(text, width), "\n"));
}

/// CLI11's formatter, with lines that end between words, one blank line instead of two, and names as help2man knows them: "-o,
/// --output", two spaces before the description.
class HelpFormatter : public CLI::Formatter {
 public:
  std::string make_help(const CLI::App* app, std::string name, CLI::AppFormatMode mode) const override {
    std::string help = CLI::Formatter::make_help(app, std::move(name), mode);
    boost::replace_all(help, " \n", "\n");
    boost::replace_all(help, "\n\n\n", "\n\n");
    return help;
  }
  std::string make_description(const CLI::App* app) const override {
    return wrapped_lines(app->get_description(), kWidth) + "\n";
  }
  std::string make_option_name(const CLI::Option* option, bool is_positional) const override {
    std::string name = CLI::Formatter::make_option_name(option, is_positional);
    if (const std::size_t comma = name.find(','); comma != std::string::npos) name.insert(comma + 1, " ");
    return name;
  }
  std::string make_option_opts(const CLI::Option* option) const override {
    return CLI::Formatter::make_option_opts(option) + " ";
  }
  std::string make_option_desc(const CLI::Option* option) const override {
    return wrapped_lines(option->get_description(), kWidth - kNameColumn);
  }
};

/// The subcommands in the order of the help.
constexpr Command kCommands[] = {
    {"run", "From a log to a global map: splits, builds local maps, joins, recovers, polishes", declare_run},
    {"build", "From a log, or the files of local maps, to a store", declare_build},
    {"join", "From local maps to a global map", declare_join},
    {"solve", "Full SLAM of a log, as the join of one-step maps", declare_solve},
    {"compare", "Joining beside full SLAM on one log: what each takes, and how far its map is from the best", declare_compare},
    {"basin", "From which starts the optimum is reached: full SLAM and joining, absolute and relative", declare_basin},
    {"convexity", "How far from convex and from linear: full SLAM and joining, absolute and relative", declare_convexity},
    {"plot", "Pictures of maps, logs and local maps, and pages to look around in", declare_plot},
    {"simulate", "A log with its truth", declare_simulate},
    {"info", "What is in a file", declare_info},
    {"check", "What could be wrong with a log, before it is joined", declare_check},
    {"error", "How far a map or a trajectory is from the truth", declare_error},
    {"covariance", "How certain named poses and features are, together and relative to each other", declare_covariance},
    {"convert", "A log or local maps in another format", declare_convert},
};

std::string footer(const std::string& program) {
  std::string exit_codes = "Exit codes:";
  for (const auto& [code, text, kind] : kExitCodes) exit_codes += fmt::format(" {} {},", static_cast<int>(code), text);
  exit_codes.back() = '.';
  return fmt::format("`{} COMMAND --help` lists a command's options, with examples.\n", program) +
         wrapped_lines(exit_codes, kWidth);
}

}  // namespace

CommandLine command_line() {
  return command_line("mapjoin", kDescription, kCommands);
}

CommandLine command_line(const std::string& program, const std::string& description, std::span<const Command> commands) {
  CommandLine line{std::make_shared<CLI::App>(description, program), {}};
  CLI::App& app = *line.app;
  app.formatter(std::make_shared<HelpFormatter>());
  app.get_formatter()->column_width(kNameColumn);
  app.get_formatter()->label("SUBCOMMAND", "COMMAND");
  app.get_formatter()->label("Positionals", "Arguments");
  app.set_help_flag("-h,--help", "This text");
  app.set_version_flag("--version", fmt::format("{} {}", program, kVersion), "The version");
  app.require_subcommand(1);
  app.footer(footer(program));
  for (const auto& [name, what, declare] : commands) {
    declare(*line.commands.emplace_back(std::make_unique<Subcommand>(app, name, what)));
  }
  return line;
}

}  // namespace mapjoin::apps
