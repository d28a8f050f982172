// SPDX-License-Identifier: BSD-3-Clause
// The `mapjoin-mpi` command: one process of it on each rank.

#include <apps/console.hpp>
#include <apps/mpi/by_ranks.hpp>
#include <apps/program.hpp>
#include <cstdlib>
#include <mapjoin/distributed/mpi/communicator.hpp>

namespace mapjoin::apps {
namespace {

constexpr const char* kDescription =
    "Builds maps that are too large for one machine: every rank of an MPI job builds the local maps of its part of a log, "
    "takes a region of "
    "the map, and what regions share is solved by all of them.";

constexpr Command kCommands[] = {
    {"run", "From a log to a global map: splits, builds local maps, aligns, and minimises the whole log", declare_mpi_run},
    {"build", "From a log to stores of local maps, one of each rank", declare_mpi_build},
    {"join", "From stores of local maps to a global map", declare_mpi_join}};

/// Runs the command on one rank. An exception that the ranks have not agreed on ends all of them.
ExitCode on_rank(const distributed::Communicator& comm, int argc, char** argv) {
  bool is_unforeseen = false;
  const auto work = [&] {
    try {
      return parse_and_run(command_line("mapjoin-mpi", kDescription, kCommands), argc, argv, {});
    } catch (const tl::bad_expected_access<Error>&) {
      throw;
    } catch (...) {
      is_unforeseen = true;
      throw;
    }
  };
  const auto tell = [&](const std::string& sentence) {
    if (comm.is_root() || is_unforeseen) say(sentence);
  };
  const ExitCode code = with_errors_told(work, tell);
  if (is_unforeseen) MPI_Abort(comm.mpi(), static_cast<int>(code));
  return code;
}

int main(int argc, char** argv) {
  if (const auto ready = prepare_process(); !ready) {
    say(ready.error().message);
    std::_Exit(static_cast<int>(ExitCode::kTooLarge));
  }
  int threads = MPI_THREAD_SINGLE;
  MPI_Init_thread(&argc, &argv, MPI_THREAD_SERIALIZED, &threads);
  if (threads < MPI_THREAD_SERIALIZED) {
    say("this MPI allows for no threads");
    MPI_Abort(MPI_COMM_WORLD, static_cast<int>(ExitCode::kInternalError));
  }
  const ExitCode code = on_rank(distributed::Communicator(MPI_COMM_WORLD), argc, argv);
  MPI_Finalize();
  return static_cast<int>(code);
}

}  // namespace
}  // namespace mapjoin::apps

int main(int argc, char** argv) {
  return mapjoin::apps::main(argc, argv);
}
