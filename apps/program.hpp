// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a program of ours does around its subcommands: it parses, hands over, and turns what comes of it into a sentence and an
// exit code.

#include <apps/commands/subcommand.hpp>
#include <apps/exit_code.hpp>
#include <functional>
#include <stop_token>
#include <string>

namespace mapjoin::apps {

/// Before anything else of a process: its limits, its BLAS and its signals. kTooLarge where the limits leave too little.
Expected<void> prepare_process();

/// Parses, and does what the chosen subcommand does; a wrong command line fails with kUsage.
ExitCode parse_and_run(const CommandLine& line, int argc, char** argv, const std::stop_token& stop);

/// What `work` returns; what it throws is told in one sentence, and by an exit code.
ExitCode with_errors_told(const std::function<ExitCode()>& work, const std::function<void(const std::string&)>& tell);

}  // namespace mapjoin::apps
