// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <algorithm>
#include <apps/console.hpp>
#include <apps/process.hpp>
#include <apps/program.hpp>
#include <cctype>
#include <exception>
#include <map>
#include <new>
#include <set>
#include <sstream>

namespace mapjoin::apps {
namespace {

/// Fails with a sentence on a wrong command line, which names the help that lists what there is.
[[noreturn]] void fail_to_parse(const CLI::App& app, std::string what) {
  const auto commands = app.get_subcommands();
  const auto before = app.remaining();  // what stands before the command
  const auto word = std::ranges::find_if(before, [](const std::string& argument) { return !argument.starts_with("-"); });
  std::string command = app.get_name();
  if (word != before.end()) {
    what = fmt::format("there is no command \"{}\"", *word);
  } else if (commands.empty()) {
    what = "a command is required";
  } else {
    command += " " + commands.front()->get_name();
  }
  fail(ErrorKind::kUsage, fmt::format("{} (see {} --help)", what, command));
}

/// An option that a sentence offers, or the argument for further inputs, and the word behind it.
struct Offer {
  std::string option;
  std::string word;
};

/// What a sentence offers behind its first semicolon.
std::vector<Offer> offers_in(const std::string& sentence) {
  std::vector<Offer> offers;
  std::istringstream words(sentence.substr(std::min(sentence.size(), sentence.find("; "))));
  bool is_behind_option = false;
  for (std::string word; words >> word;) {
    const auto is_of_name = [](char c) { return std::isalnum(static_cast<unsigned char>(c)) != 0 || c == '-'; };
    word.erase(std::ranges::find_if_not(word, is_of_name), word.end());
    if (is_behind_option) offers.back().word = word;
    is_behind_option = word.starts_with("--") || word == kFurther;
    if (is_behind_option) offers.push_back({word, ""});
  }
  return offers;
}

/// What a command lacks of an offer: the option or, of a choice, the word, as in "--parts all"; empty if it lacks nothing.
std::string lacking_of(const Offer& offer, const Subcommand& command, bool is_choice) {
  if (!command.has(offer.option)) return offer.option;
  return is_choice && !command.has_choice(offer.option, offer.word) ? offer.option + " " + offer.word : "";
}

/// What stands in the place of the log after a run with these options: its folder, or one of each part in it.
std::string folder_after(const std::set<std::string>& options) {
  if (options == std::set<std::string>{"--parts all"}) return "DIR/part_1, …";
  const bool is_of_parts = options.contains("--parts") || options.contains("--parts all");
  return is_of_parts ? "DIR, or with all DIR/part_1, …," : "DIR";
}

/// The sentence, followed by the commands that have what it offers and the chosen command lacks; a folder of a run with that
/// can be given in the place of the log. Unchanged if it names a command.
std::string with_owners(std::string sentence, const Subcommand& chosen, const CommandLine& line) {
  if (sentence.find("`mapjoin ") != sentence.npos) return sentence;
  std::map<std::string, std::set<std::string>> lacking;  // by the command that has them
  for (const Offer& offer : offers_in(sentence)) {
    const auto has = [&](const auto& command) { return command->has(offer.option); };
    const auto has_choice = [&](const auto& command) { return command->has_choice(offer.option, offer.word); };
    const auto chooser = std::ranges::find_if(line.commands, has_choice);
    const bool is_choice = chooser != line.commands.end();
    const auto owner = is_choice ? chooser : std::ranges::find_if(line.commands, has);
    const std::string lacked = lacking_of(offer, chosen, is_choice);
    if (owner != line.commands.end() && !lacked.empty()) lacking[(*owner)->name()].insert(lacked);
  }
  for (const auto& [owner, options] : lacking) {
    const std::string then = owner == "run" ? fmt::format(" -o DIR`, and {} can be given here", folder_after(options)) : "`";
    sentence += fmt::format("; {} {} with `{} {}{}", fmt::join(options, " and "), options.size() == 1 ? "goes" : "go",
                            line.app->get_name(), owner, then);
  }
  return sentence;
}

}  // namespace

Expected<void> prepare_process() {
  occupy_standard_streams();
  if (auto room = check_process_limits(); !room) return room;
  keep_blas_on_one_thread();
  end_on_truncated_input();
  return {};
}

ExitCode parse_and_run(const CommandLine& line, int argc, char** argv, const std::stop_token& stop) {
  CLI::App& app = *line.app;
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    demand(write_stdout(app.help()));
    return ExitCode::kDone;
  } catch (const CLI::CallForVersion& version) {
    demand(write_stdout(fmt::format("{}\n", version.what())));
    return ExitCode::kDone;
  } catch (const CLI::ParseError& error) {
    fail_to_parse(app, error.what());
  }
  const auto is_chosen = [](const auto& command) { return command->is_chosen(); };
  const auto chosen = std::find_if(line.commands.begin(), line.commands.end(), is_chosen);
  try {
    return (*chosen)->run(stop);
  } catch (const tl::bad_expected_access<Error>& failure) {
    const auto& [kind, message] = failure.error();
    if (kind == ErrorKind::kInterrupted) fail(kind, "interrupted");
    // Other errors are told even after a stop: --follow ends with one.
    fail(kind, kind == ErrorKind::kUsage ? message : with_owners(message, **chosen, line));
  }
}

ExitCode with_errors_told(const std::function<ExitCode()>& work, const std::function<void(const std::string&)>& tell) {
  try {
    return work();
  } catch (const tl::bad_expected_access<Error>& failure) {
    tell(failure.error().message);
    return exit_code_of(failure.error().kind);
  } catch (const std::bad_alloc&) {
    tell("there is not enough memory for this");
    return ExitCode::kTooLarge;
  } catch (const std::exception& error) {
    tell(fmt::format("internal error: {}", error.what()));
    return ExitCode::kInternalError;
  }
}

}  // namespace mapjoin::apps
