// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// From a g2o file to a global map, by all ranks together.

#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/distributed/mumps.hpp>
#include <mapjoin/io/read_options.hpp>
#include <mapjoin/join/run.hpp>
#include <variant>

namespace mapjoin::distributed {

/// What is asked of all ranks alike.
struct Task {
  std::filesystem::path log;
  ReadOptions read;
  RunOptions run;
  MumpsOptions mumps;
  double most_megabytes = 0.0;  ///< Of factors, on any rank (10⁶ bytes); 0: no bound.
};

/// How much there is of the log.
struct LogCounts {
  std::int64_t odometry = 0;
  std::int64_t closures = 0;
  std::int64_t observations = 0;
  std::int64_t priors = 0;
  std::int64_t fixed_poses = 0;
  SkipCounts skipped{};
};

/// What came of it. The figures are the first rank's where they are not of all; the join is that of full SLAM.
template <int Dim>
struct Found {
  RunResult<Dim> result;  ///< With the map on the first rank.
  LogCounts counts;
  Conventions conventions;
};
using AnyFound = std::variant<Found<2>, Found<3>>;

/// Bad input, the same on all ranks, as of mapjoin::run(); kTooLarge where factors would be larger than `most_megabytes`.
Expected<AnyFound> run(const Communicator& comm, const Task& task);

}  // namespace mapjoin::distributed
