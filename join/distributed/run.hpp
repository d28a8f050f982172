// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The global map of a log from its local maps, by all ranks together.

#include <functional>
#include <mapjoin/distributed/mapped_log.hpp>
#include <mapjoin/distributed/mpi/mumps.hpp>
#include <variant>

namespace mapjoin::distributed {

/// A task, the same on all ranks.
struct Task {
  RunOptions run;
  MumpsOptions mumps;
  double most_megabytes = 0.0;  ///< Bound on the factors of any rank (10⁶ bytes); 0: none.
  std::size_t regions = 1;      ///< Number of regions per rank, which takes them in turn.
};

/// Reads the log, by all ranks together: once for each way that is tried.
using Reading = std::function<Expected<AnyMappedLog>()>;

/// The result of a task. Figures that are not of all ranks are those of the first rank; the join is that of full SLAM.
template <int Dim>
struct Found {
  RunResult<Dim> result;  ///< Its map is on the first rank only.
  LogFigures log;
  std::size_t shared_by_regions = 0;  ///< Number of unknowns that several regions have.
  std::size_t shared_by_ranks = 0;    ///< Number of unknowns that regions of several ranks have.
};
using AnyFound = std::variant<Found<2>, Found<3>>;

/// Joins the local maps of a log. Errors are the same on all ranks: those of `read`; kBadInput as of mapjoin::run(); kUsage as
/// of check_worth_it(); kTooLarge if factors would be larger than `most_megabytes`; kCannotWrite if the file of a factor cannot
/// be made.
Expected<AnyFound> run(const Communicator& comm, const Reading& read, const Task& task);

}  // namespace mapjoin::distributed
