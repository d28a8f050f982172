// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A local map: an integrated observation, from its start pose, of the poses it keeps and of its features (paper's (31)).

#include <Eigen/Core>
#include <algorithm>
#include <cstddef>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/observation.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

/// A Gaussian over kept poses and features in the frame of the start pose `base`. The targets are the poses, then the features;
/// `information` is over their steps in that order (kPoseDof<Dim> rows a pose, Dim rows a feature).
template <int Dim>
struct LocalMap {
  Index base = 0;
  std::vector<Index> poses;  ///< Kept poses in ascending order, the end pose last.
  std::vector<Index> features;
  std::vector<Pose<Dim>> pose_estimates;      ///< In the frame of the base.
  std::vector<Point<Dim>> feature_estimates;  ///< In the frame of the base (m).
  Eigen::MatrixXd information;                ///< W, symmetric positive semidefinite.
  double chi2 = 0.0;                          ///< Of the observations inside, at the estimate.

  /// The first row of a target in `information`; of the number of targets, the number of rows.
  Eigen::Index row(std::size_t target) const {
    const std::size_t before = std::min(target, poses.size());
    return static_cast<Eigen::Index>(before * kPoseDof<Dim> + (target - before) * Dim);
  }
};

/// Poses [begin, end] that are joined as one, both included: neighbours of one session share their end/start pose.
struct Stretch {
  Index begin = 0;
  Index end = 0;
  bool is_map = true;  ///< A local map from its start to its end pose, else a span of its observations as they are.
  bool operator==(const Stretch&) const = default;
};

/// What there is to join: local maps, and observations that stand on their own (one-step maps), over shared poses and features.
template <int Dim>
struct MapSet {
  std::string source;  ///< The file or folder it was read from, for messages.
  std::vector<PoseId> poses;
  std::vector<FeatureId> features;

  std::vector<LocalMap<Dim>> maps;                      ///< In the order of their base.
  std::vector<PoseObservation<Dim>> pose_observations;  ///< Of spans, closures and priors.
  std::vector<FeatureObservation<Dim>> feature_observations;
  std::vector<FixedPose<Dim>> fixed;

  std::vector<Stretch> stretches;
  Conventions conventions;
};

/// What is wrong with the numbers of a map, "has … that …"; nothing where its estimates are finite, as many as its targets, and
/// its information matrix is of their size and passes InformationCheck.
template <int Dim>
std::optional<std::string> fault(const LocalMap<Dim>& map);

/// Bad input, named by its poses, unless every map and observation of a set made in memory is over poses and features of the
/// set and has sound numbers.
template <int Dim>
Expected<void> check_numbers(const MapSet<Dim>& set);

/// Every information matrix replaced by the identity, in place, those of the maps among them; the conventions say so.
template <int Dim>
void use_identity_covariance(MapSet<Dim>& set);

}  // namespace mapjoin
