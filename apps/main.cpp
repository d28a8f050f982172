// SPDX-License-Identifier: BSD-3-Clause
// The `mapjoin` command: parses, hands over to a subcommand, and turns what comes of it into a sentence and an exit code.

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <algorithm>
#include <apps/commands/subcommand.hpp>
#include <apps/console.hpp>
#include <apps/process.hpp>
#include <cstdlib>
#include <exception>
#include <new>

namespace mapjoin::apps {
namespace {

/// A command line that is wrong, in one sentence.
[[noreturn]] void fail_to_parse(const CLI::App& app, std::string what) {
  if (app.get_subcommands().empty()) {
    const auto words = app.remaining();
    what = words.empty() ? "a command is required" : fmt::format("there is no command \"{}\"", words.front());
  }
  fail(ErrorKind::kUsage, what + " (see mapjoin --help)");
}

ExitCode parse_and_run(int argc, char** argv) {
  const Interruption interruption;
  const CommandLine line = command_line();
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
    return (*chosen)->run(interruption.token());
  } catch (const tl::bad_expected_access<Error>& failure) {
    if (failure.error().kind == ErrorKind::kInterrupted) fail(ErrorKind::kInterrupted, "interrupted");
    throw;  // what went wrong otherwise is said, be it after a stop: --follow ends with one
  }
}

ExitCode main(int argc, char** argv) {
  if (const auto room = check_process_limits(); !room) {
    say(room.error().message);
    std::_Exit(static_cast<int>(ExitCode::kTooLarge));  // OpenBLAS would wait for its threads, which ask for memory for ever
  }
  keep_blas_on_one_thread();
  end_on_truncated_input();
  try {
    return parse_and_run(argc, argv);
  } catch (const tl::bad_expected_access<Error>& failure) {
    say(failure.error().message);
    return exit_code_of(failure.error().kind);
  } catch (const std::bad_alloc&) {
    say("there is not enough memory for this");
    return ExitCode::kTooLarge;
  } catch (const std::exception& error) {
    say(fmt::format("internal error: {}", error.what()));
    return ExitCode::kInternalError;
  }
}

}  // namespace
}  // namespace mapjoin::apps

int main(int argc, char** argv) {
  return static_cast<int>(mapjoin::apps::main(argc, argv));
}
