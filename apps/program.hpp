// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The frame of a program around its subcommands: parses, runs the chosen one, and turns errors into a sentence and an exit
// code.

#include <apps/commands/subcommand.hpp>
#include <apps/exit_code.hpp>
#include <functional>
#include <stop_token>
#include <string>

namespace mapjoin::apps {

/// Prepares the streams, the limits, the BLAS and the signals of a process, before anything else. kTooLarge if the limits leave
/// too little.
Expected<void> prepare_process();

/// Parses the command line and runs the chosen subcommand; kUsage if the command line is wrong.
ExitCode parse_and_run(const CommandLine& line, int argc, char** argv, const std::stop_token& stop);

/// The exit code of `work`; whatever it throws is told in one sentence, and by an exit code.
ExitCode with_errors_told(const std::function<ExitCode()>& work, const std::function<void(const std::string&)>& tell);

}  // namespace mapjoin::apps
