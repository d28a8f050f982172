// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// chi2 of a log at given poses and features, observation by observation, apart from every solver.

#include <cstddef>
#include <cstdint>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Sums of squared Mahalanobis residuals rᵀWr (no factor 1/2), by kind.
struct Chi2 {
  double odometry = 0.0;
  double closures = 0.0;
  double observations = 0.0;
  double priors = 0.0;  ///< Of poses and of features.

  double total() const { return odometry + closures + observations + priors; }
};

/// chi2 of a log at values of all its poses and features, in the World frame. Fixed poses count as they stand in `values`.
/// Throws std::invalid_argument where there are more or fewer values than poses or features.
template <int Dim>
Chi2 log_chi2(const Log<Dim>& log, const Values<Dim>& values);

/// The same of all factors of a graph, without its submaps.
template <int Dim>
double graph_chi2(const FactorGraph<Dim>& graph, const Values<Dim>& values);

/// What chi2 has as its expected value at the optimum of a consistent log: measured rows (the rank of every W) less unknowns,
/// where `held_poses` poses are anchored (see GlobalMap::gauge; fixed ones count among them).
template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log, std::size_t held_poses);

}  // namespace mapjoin
