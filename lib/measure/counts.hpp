// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Counts of the contents of an input.

#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// The counts of a log or a set of maps, of one process or of all ranks.
struct Counts {
  std::size_t sessions = 0;
  std::size_t poses = 0;
  std::size_t features = 0;
  std::size_t odometry = 0;
  std::size_t closures = 0;
  std::size_t observations = 0;  ///< Single observations; those inside the local maps of a set are not known.
  std::size_t map_features = 0;  ///< Features of all maps of a set, added up.
  std::size_t priors = 0;        ///< Priors of poses and of features.
  std::size_t fixed_poses = 0;
  std::int64_t repeated_edges = 0;
  std::int64_t unassociated = 0;
  SkipCounts skipped{};
  std::size_t repeated_steps = 0;
  std::size_t shared_features = 0;  ///< Features of several inputs, seen in more than one session.
};

}  // namespace mapjoin
