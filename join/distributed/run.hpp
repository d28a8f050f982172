// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// From a log and its local maps to a global map, by all ranks together.

#include <functional>
#include <mapjoin/distributed/mapped_log.hpp>
#include <mapjoin/distributed/mpi/mumps.hpp>
#include <variant>

namespace mapjoin::distributed {

/// What is asked of all ranks alike.
struct Task {
  RunOptions run;
  MumpsOptions mumps;
  double most_megabytes = 0.0;  ///< Of factors, on any rank (10⁶ bytes); 0: no bound.
  std::size_t regions = 1;      ///< Of each rank, one after the other.
};

/// How the log comes in, by all ranks together: once for each way that is tried.
using Reading = std::function<Expected<AnyMappedLog>()>;

/// What came of it. The figures are the first rank's where they are not of all; the join is that of full SLAM.
template <int Dim>
struct Found {
  RunResult<Dim> result;  ///< With the map on the first rank.
  LogFigures log;
  std::size_t shared_by_regions = 0;  ///< Unknowns that several regions have,
  std::size_t shared_by_ranks = 0;    ///< and those of them that regions of several ranks have.
};
using AnyFound = std::variant<Found<2>, Found<3>>;

/// Bad input, the same on all ranks, as of mapjoin::run(); kTooLarge where factors would be larger than `most_megabytes`.
Expected<AnyFound> run(const Communicator& comm, const Reading& read, const Task& task);

}  // namespace mapjoin::distributed
