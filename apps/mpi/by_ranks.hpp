// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What the subcommands of `mapjoin-mpi` have in common: all ranks work, the first one tells.

#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <functional>
#include <mapjoin/distributed/mapped_log.hpp>

namespace mapjoin::apps {

struct MpiOptions : Options {
  MpiOptions() { jobs = 1; }
  std::filesystem::path out_of_core;
  std::int64_t regions = 1;
  std::filesystem::path stores;  ///< A folder; empty: none.
};

/// What `work` returns on the first rank, on all of them; its failure, too.
ExitCode told_by_first(const distributed::Communicator& comm, const std::function<ExitCode()>& work);

/// Describes a log of so many dimensions that is spread over ranks.
void describe(int dimension, const distributed::LogFigures& log, RunReport& run_report);

/// What ranks needed, in one line; by all ranks.
std::string effort_in_words(const distributed::Communicator& comm);
/// CommandRun::conclude(), and what ranks needed where people read; by the first rank.
ExitCode conclude(CommandRun& command_run, const std::string& effort);

/// A command that makes a map of the log that `read` brings in, once for each way that is tried.
ExitCode make_map(const std::string& command, const MpiOptions& options,
                  const std::function<Expected<distributed::AnyMappedLog>(const distributed::Communicator&)>& read);

/// In words, a log or a report in the place of a rank's store, in the folder that `option` names.
std::vector<std::string> store_conflicts(const MpiOptions& options, const std::string& option);

/// What such a command takes beside its input: --schedule, --regions, --out-of-core, --max-memory, and options of the solver
/// and the report.
void add_way_of_ranks(Subcommand& command, MpiOptions& options);

void declare_mpi_run(Subcommand& command);
void declare_mpi_build(Subcommand& command);
void declare_mpi_join(Subcommand& command);

}  // namespace mapjoin::apps
