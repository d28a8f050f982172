// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The factors of a least-squares problem over poses and features, and selections of them.

#include <algorithm>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/local_map.hpp>
#include <vector>

namespace mapjoin {

/// A pose fixed in the World frame.
template <int Dim>
struct FixedPose {
  PoseIndex pose = 0;
  Pose<Dim> value;  ///< In the World frame.
};

/// Fixed poses in ascending order, each once. kBadInput if a pose is fixed at two places; `poses` names them.
template <int Dim>
Expected<std::vector<FixedPose<Dim>>> fixed_once(std::vector<FixedPose<Dim>> fixed, const PoseIds& poses) {
  std::ranges::stable_sort(fixed, {}, &FixedPose<Dim>::pose);
  const auto is_same_pose = [](const auto& a, const auto& b) { return a.pose == b.pose; };
  const auto differing =
      std::ranges::adjacent_find(fixed, [&](const auto& a, const auto& b) { return is_same_pose(a, b) && a.value != b.value; });
  if (differing != fixed.end()) return bad_input(to_string(poses[differing->pose]) + " is fixed at two places");
  fixed.erase(std::unique(fixed.begin(), fixed.end(), is_same_pose), fixed.end());
  return fixed;
}

/// Factors over poses and over features, each indexed from 0. A factor whose base is kWorld is a prior.
template <int Dim>
struct FactorGraph {
  std::vector<PoseFactor<Dim>> pose_factors;        ///< Odometry, closures, and priors of poses.
  std::vector<FeatureFactor<Dim>> feature_factors;  ///< Observations and priors of features.
  std::vector<LocalMap<Dim>> submaps;               ///< Integrated observations, in the order of their base.
  std::vector<FixedPose<Dim>> fixed;                ///< Each pose once.
};

/// True if a prior has a lever, which some algorithms on factors do not support.
template <int Dim>
bool has_levers(const FactorGraph<Dim>& graph) {
  return std::ranges::any_of(graph.pose_factors, [](const auto& factor) { return !factor.lever.isZero(0.0); });
}

/// The number of factors with a loss of their own, which no file has a place for.
template <int Dim>
std::size_t count_losses(const FactorGraph<Dim>& graph) {
  const auto has_loss = [](const auto& factor) { return factor.loss != Loss{}; };
  return static_cast<std::size_t>(std::ranges::count_if(graph.pose_factors, has_loss) +
                                  std::ranges::count_if(graph.feature_factors, has_loss));
}

/// A selection of the factors of graphs, which must outlive it. It holds pointers, since a log has millions of factors.
template <int Dim>
struct FactorSelection {
  std::vector<const PoseFactor<Dim>*> pose_factors;
  std::vector<const FeatureFactor<Dim>*> feature_factors;
  std::vector<const LocalMap<Dim>*> submaps;

  bool empty() const { return pose_factors.empty() && feature_factors.empty() && submaps.empty(); }
};

/// Replaces every information matrix of a log or a set of maps by the identity of what it measures, and records that in its
/// conventions (paper's Table I).
template <typename Data>
void use_identity_covariance(Data& data) {
  const auto replace = [](auto& information) { information = measured_identity(information); };
  for (auto& factor : data.graph.pose_factors) replace(factor.information);
  for (auto& factor : data.graph.feature_factors) replace(factor.information);
  for (auto& submap : data.graph.submaps) replace(submap.information);
  data.conventions.covariance = Covariance::kIdentity;
  data.conventions.inflation = {};
}

/// Multiplies the standard deviations of the measurements of a log or a set of maps, each by the factor of its kind, and the
/// factors in its conventions, which are those since it was read. Of a set, which has no odometry, every edge is a closure.
/// Throws std::invalid_argument if the factors do not validate.
template <typename Data>
void inflate(const Inflation& by, Data& data) {
  demand_valid(by);
  const auto weaken = [](auto& information, double factor) { information /= factor * factor; };
  std::size_t odometry = 0;
  if constexpr (requires { data.odometry(); }) odometry = data.odometry().size();
  for (std::size_t k = 0; k < data.graph.pose_factors.size(); ++k) {
    auto& factor = data.graph.pose_factors[k];
    const double of_edge = k < odometry ? by.odometry : by.closures;
    weaken(factor.information, factor.base == kWorld ? by.priors : of_edge);
  }
  for (auto& factor : data.graph.feature_factors) {
    weaken(factor.information, factor.base == kWorld ? by.priors : by.observations);
  }
  for (auto& submap : data.graph.submaps) weaken(submap.information, by.maps);
  for (const auto& [name, factor] : kInflatedKinds) data.conventions.inflation.*factor *= by.*factor;
}

}  // namespace mapjoin
