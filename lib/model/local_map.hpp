// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map: an integrated observation, from its start pose, of the poses it keeps and of its features (paper's (31)).

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <mapjoin/model/factor.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

/// A Gaussian over kept poses and features in the frame of the start pose `base`. The targets are the poses, then the features;
/// `information` is over their steps in that order (kPoseDof<Dim> rows a pose, Dim rows a feature).
template <int Dim>
struct LocalMap {
  PoseIndex base = 0;
  std::vector<PoseIndex> poses;  ///< Kept poses in ascending order, the end pose last.
  std::vector<FeatureIndex> features;
  std::vector<Pose<Dim>> pose_estimates;      ///< In the frame of the base.
  std::vector<Point<Dim>> feature_estimates;  ///< In the frame of the base (m).
  Eigen::MatrixXd information;                ///< W, symmetric positive semidefinite.
  double chi2 = 0.0;                          ///< chi2 of its own observations, at the estimate.

  /// The first row of a target in `information`; the number of rows if `target` is the number of targets.
  Eigen::Index row(std::size_t target) const {
    const std::size_t before = std::min(target, poses.size());
    return static_cast<Eigen::Index>(before * kPoseDof<Dim> + (target - before) * Dim);
  }
};

/// The fault in the numbers of a map, "has … that …"; nullopt if its estimates are finite and as many as its targets, and its
/// information matrix has their size and passes InformationCheck.
template <int Dim>
std::optional<std::string> fault(const LocalMap<Dim>& map);

}  // namespace mapjoin
