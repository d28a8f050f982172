// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/localmap/taken_apart.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The covariance of a map, large but finite for what it does not determine.
template <int Dim>
Eigen::MatrixXd covariance_of(const LocalMap<Dim>& map) {
  constexpr double kLeastShare = 1e-9;  // relative to the information of each coordinate
  Eigen::MatrixXd W = map.information;
  const double most = W.size() > 0 && W.diagonal().maxCoeff() > 0.0 ? W.diagonal().maxCoeff() : 1.0;
  for (Eigen::Index k = 0; k < W.rows(); ++k) W(k, k) += kLeastShare * (W(k, k) > 0.0 ? W(k, k) : most);
  return W.llt().solve(Eigen::MatrixXd::Identity(W.rows(), W.rows()));
}

/// The information matrix of a covariance; zero if that is not positive definite.
template <int Size>
Matrix<Size> information_by(const Matrix<Size>& covariance) {
  return information_of_covariance<Size>(covariance).value_or(Matrix<Size>::Zero());
}

/// The marginal of a map on the step to pose `t` that it keeps, from the one before it or from its base.
template <int Dim>
PoseFactor<Dim> step_to(const LocalMap<Dim>& map, const Eigen::MatrixXd& covariance, std::size_t t) {
  constexpr int kDof = kPoseDof<Dim>;
  const Pose<Dim>& pose = map.pose_estimates[t];
  if (t == 0) return {map.base, map.poses[0], pose, information_by<kDof>(covariance.topLeftCorner<kDof, kDof>()), {}};
  const Pose<Dim>& before = map.pose_estimates[t - 1];
  const auto linear = linearise<Dim>(between(before, pose), before, pose);
  Eigen::Matrix<double, kDof, 2 * kDof> J;
  J << linear.J_base, linear.J_target;
  const auto both = covariance.block<2 * kDof, 2 * kDof>(map.row(t - 1), map.row(t - 1));
  return {map.poses[t - 1], map.poses[t], between(before, pose), information_by<kDof>(J * both * J.transpose()), {}};
}

}  // namespace

template <int Dim>
TakenApart<Dim> taken_apart(const SubmapSet<Dim>& set) {
  TakenApart<Dim> apart;
  Log<Dim>& log = apart.log;
  log.source = set.source;
  log.poses = set.poses;
  log.features = set.features;
  log.graph = {set.graph.pose_factors, {}, {}, fixed_once(set.graph.fixed, set.poses).value()};
  using Sighting = std::pair<FeatureFactor<Dim>, typename TakenApart<Dim>::Origin>;
  std::vector<Sighting> sightings;
  for (const auto& o : set.graph.feature_factors) sightings.push_back({o, {set.graph.submaps.size(), sightings.size()}});
  for (std::size_t m = 0; m < set.graph.submaps.size(); ++m) {
    const LocalMap<Dim>& map = set.graph.submaps[m];
    const Eigen::MatrixXd covariance = covariance_of(map);
    for (std::size_t t = 0; t < map.poses.size(); ++t) log.graph.pose_factors.push_back(step_to(map, covariance, t));
    for (std::size_t f = 0; f < map.features.size(); ++f) {
      const Eigen::Index row = map.row(map.poses.size() + f);
      const PointMatrix<Dim> information = information_by<Dim>(covariance.block<Dim, Dim>(row, row));
      sightings.push_back({{map.base, map.features[f], map.feature_estimates[f], information, {}}, {m, f}});
    }
  }
  // The order of put_in_order().
  std::ranges::stable_sort(sightings, {}, [](const Sighting& s) { return std::pair(s.first.base == kWorld, s.first.base); });
  for (const auto& [observation, origin] : sightings) {
    log.graph.feature_factors.push_back(observation);
    apart.origins.push_back(origin);
  }
  put_in_order(log);
  return apart;
}

template TakenApart<2> taken_apart(const SubmapSet<2>&);
template TakenApart<3> taken_apart(const SubmapSet<3>&);

}  // namespace mapjoin
