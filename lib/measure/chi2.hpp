// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// chi2 of a log at given poses and features, observation by observation, independent of every solver.

#include <cstddef>
#include <cstdint>
#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Sums of squared Mahalanobis residuals rᵀWr (no factor 1/2), by kind.
struct Chi2 {
  double odometry = 0.0;
  double closures = 0.0;
  double observations = 0.0;
  double priors = 0.0;  ///< Priors of poses and of features.

  double total() const { return odometry + closures + observations + priors; }
};

/// chi2 of a log at values of all its poses and features, in the World frame. Fixed poses count as they stand in `values`.
/// Throws std::invalid_argument if the numbers of values are not those of poses and features.
template <int Dim>
Chi2 log_chi2(const Log<Dim>& log, const Values<Dim>& values);

/// chi2 of all factors of a graph, without its submaps.
template <int Dim>
double graph_chi2(const FactorGraph<Dim>& graph, const Values<Dim>& values);

/// Degrees of freedom, the expected chi2 at the optimum of a consistent log: measured rows (the rank of every W) less unknowns,
/// with `held_poses` poses anchored (see GlobalMap::gauge; fixed ones count among them).
template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log, std::size_t held_poses);

/// The same with the poses anchored that a join anchors: the fixed ones or, if there are neither these nor priors, the first.
template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log);

}  // namespace mapjoin
