// SPDX-License-Identifier: BSD-3-Clause
// The `mapjoin` command: parses, hands over to a subcommand, and turns what comes of it into a sentence and an exit code.

#include <fmt/format.h>

#include <CLI/App.hpp>
#include <CLI/Config.hpp>
#include <algorithm>
#include <apps/blas.hpp>
#include <apps/commands/commands.hpp>
#include <apps/console.hpp>
#include <apps/interruption.hpp>
#include <apps/truncated_input.hpp>
#include <cstdlib>
#include <exception>
#include <new>

namespace mapjoin::apps {
namespace {

/// Of --help and --version.
Expected<ExitCode> told(const std::string& text) {
  return write_stdout(text).map([] { return ExitCode::kDone; });
}

/// A command line that is wrong, in one sentence.
tl::unexpected<Error> misused(const CLI::App& app, const std::string& what) {
  std::string sentence = what;
  if (app.get_subcommands().empty()) {
    const auto words = app.remaining();
    sentence = words.empty() ? "a command is required" : fmt::format("there is no command \"{}\"", words.front());
  }
  return tl::unexpected(Error{ErrorKind::kUsage, sentence + " (see mapjoin --help)"});
}

Expected<ExitCode> parse_and_run(int argc, char** argv) {
  const Interruption interruption;
  const CommandLine line = command_line();
  CLI::App& app = *line.app;
  try {
    app.parse(argc, argv);
  } catch (const CLI::CallForHelp&) {
    return told(app.help());
  } catch (const CLI::CallForVersion& version) {
    return told(fmt::format("{}\n", version.what()));
  } catch (const CLI::ParseError& error) {
    return misused(app, error.what());
  }
  const auto chosen =
      std::find_if(line.commands.begin(), line.commands.end(), [](const auto& command) { return command->is_chosen(); });
  auto done = (*chosen)->run(interruption.token());
  if (!done && interruption.token().stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  return done;
}

ExitCode main(int argc, char** argv) {
  if (const auto room = check_process_limits(); !room) {
    say(room.error().message);
    std::_Exit(static_cast<int>(ExitCode::kTooLarge));  // OpenBLAS would wait for its threads, which ask for memory for ever
  }
  keep_blas_on_one_thread();
  end_on_truncated_input();
  try {
    const auto done = parse_and_run(argc, argv);
    if (done) return *done;
    say(done.error().message);
    return exit_code_of(done.error().kind);
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
