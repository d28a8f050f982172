// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The cost ρ(rᵀWr) of an observation at given values: the terms of every chi2.

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/model/local_map.hpp>

namespace mapjoin {

/// The cost of an observation of one target, a pose or a feature. `base` is the identity if it is the World.
template <template <int> typename Observation, int Dim, typename Target>
double cost(const Observation<Dim>& observation, const Pose<Dim>& base, const Target& target) {
  const auto r = residual<Dim>(observation.measured, base, measured_part(observation, target));
  return evaluate(observation.loss, r.dot(observation.information * r)).cost;
}

/// The residual X̂ - H(X) of a local map (paper's (31)): its poses, then its features, in the rows of its information.
/// `pose_at(p)` and `feature_at(f)` give the values of the map's p-th pose and f-th feature, in the same frame as `base`.
template <int Dim, typename PoseAt, typename FeatureAt>
Eigen::VectorXd residual(const LocalMap<Dim>& map, const Pose<Dim>& base, PoseAt&& pose_at, FeatureAt&& feature_at) {
  Eigen::VectorXd r(map.information.rows());
  Eigen::Index row = 0;
  for (std::size_t p = 0; p < map.poses.size(); ++p, row += kPoseDof<Dim>) {
    r.segment<kPoseDof<Dim>>(row) = residual<Dim>(map.pose_estimates[p], base, pose_at(p));
  }
  for (std::size_t f = 0; f < map.features.size(); ++f, row += Dim) {
    r.segment<Dim>(row) = residual<Dim>(map.feature_estimates[f], base, feature_at(f));
  }
  return r;
}

/// The cost of a local map with the residual `r`; its loss is quadratic.
template <int Dim>
double cost(const LocalMap<Dim>& map, const Eigen::VectorXd& r) {
  return evaluate(Loss{}, r.dot(map.information * r)).cost;
}

/// The cost of a local map at given values, with the arguments of residual().
template <int Dim, typename PoseAt, typename FeatureAt>
double cost(const LocalMap<Dim>& map, const Pose<Dim>& base, PoseAt&& pose_at, FeatureAt&& feature_at) {
  return cost(map, residual(map, base, pose_at, feature_at));
}

}  // namespace mapjoin
