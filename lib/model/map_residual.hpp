// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The residual of a whole local map (paper's (31)).

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/model/linearise.hpp>
#include <mapjoin/model/local_map.hpp>

namespace mapjoin {

/// X̂ - H(X) of all targets, in the order of the map's information. `pose_at(p)` and `feature_at(f)` give the value of the map's
/// p-th pose and f-th feature in the frame that `base` is given in.
template <int Dim, typename PoseAt, typename FeatureAt>
Eigen::VectorXd map_residual(const LocalMap<Dim>& map, const Pose<Dim>& base, PoseAt&& pose_at, FeatureAt&& feature_at) {
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

}  // namespace mapjoin
