// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Work that the subcommands of `mapjoin-mpi` share: all ranks work, the first one tells.

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <functional>
#include <mapjoin/distributed/mapped_log.hpp>

namespace mapjoin::apps {

struct MpiOptions : Options {
  MpiOptions() { jobs = 1; }
  std::filesystem::path out_of_core;
  std::int64_t regions = 1;
  std::filesystem::path stores;  ///< Folder of the ranks' stores; empty: none.
};

/// Runs `work` on the first rank, and returns its result, or fails as it does, on all of them.
ExitCode told_by_first(const distributed::Communicator& comm, const std::function<ExitCode()>& work);

/// Takes a log of this dimension that is spread over ranks into the report.
void describe(int dimension, const distributed::LogFigures& log, RunReport& run_report);

/// The number of ranks and the largest memory of one, in one line; called by all ranks.
std::string effort_in_words(const distributed::Communicator& comm);
/// Concludes the run, and tells people the effort of the ranks; called by the first rank.
ExitCode conclude(CommandRun& command_run, const std::string& effort);

/// Reads a log with its local maps, and calls the check of names.
using MappedLogReader =
    std::function<Expected<distributed::AnyMappedLog>(const distributed::Communicator&, const distributed::NamesCheck&)>;
/// Runs a command that makes a map of the log that `read` returns, called once for each way that is tried.
ExitCode make_map(const std::string& command, const MpiOptions& options, const MappedLogReader& read);

/// Violations, in words: a log or a report in the place of a rank's store, in the folder that `option` names.
std::vector<std::string> store_conflicts(const MpiOptions& options, const std::string& option);

/// Adds the options of such a command: --schedule, --regions, --out-of-core, --max-memory, and those of the solver and the
/// report.
void add_way_of_ranks(Subcommand& command, MpiOptions& options);

void declare_mpi_run(Subcommand& command);
void declare_mpi_build(Subcommand& command);
void declare_mpi_join(Subcommand& command);

}  // namespace mapjoin::apps
