// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <mapjoin/measure/trajectory_error.hpp>
#include <numeric>
#include <stdexcept>

namespace mapjoin {
namespace {

ErrorSummary summary_of(const std::vector<double>& errors) {
  if (errors.empty()) return {};
  const double squares = std::inner_product(errors.begin(), errors.end(), errors.begin(), 0.0);
  return {errors.size(), std::sqrt(squares / static_cast<double>(errors.size())), *std::ranges::max_element(errors)};
}

template <int Dim>
struct PoseErrors {
  std::vector<double> translation{};
  std::vector<double> rotation{};

  void add(const Pose<Dim>& a, const Pose<Dim>& b) {
    const PoseVector<Dim> delta = local(a, b);
    translation.push_back(delta.template head<Dim>().norm());
    rotation.push_back(delta.template tail<kRotationDof<Dim>>().norm());
  }
  PoseErrorSummary summary() const { return {summary_of(translation), summary_of(rotation)}; }
};

void require_same_size(std::size_t a, std::size_t b) {
  if (a != b) throw std::invalid_argument("Trajectories of different lengths cannot be compared");
}

template <int Dim>
std::vector<Point<Dim>> positions(const std::vector<Pose<Dim>>& poses) {
  std::vector<Point<Dim>> points;
  points.reserve(poses.size());
  for (const Pose<Dim>& pose : poses) points.push_back(pose.translation);
  return points;
}

template <int Dim>
Point<Dim> mean(const std::vector<Point<Dim>>& points) {
  return std::accumulate(points.begin(), points.end(), Point<Dim>(Point<Dim>::Zero())) / static_cast<double>(points.size());
}

/// Calls `both(value in a, value in b)` for every id that both hold and returns how many ids only one of them holds.
template <typename Index, typename Id, typename Value, typename Both>
std::size_t match(const Table<Index, Id>& ids_a, const Table<Index, Value>& a, const Table<Index, Id>& ids_b,
                  const Table<Index, Value>& b, Both&& both) {
  const IndexOf index_b(ids_b);
  std::size_t unmatched = ids_a.size() + ids_b.size();
  for (const Index i : indices(ids_a)) {
    const auto j = index_b(ids_a[i]);
    if (!j) continue;
    both(a[i], b[*j]);
    unmatched -= 2;
  }
  return unmatched;
}

/// The rotation R of largest tr(Rᵀ C).
Rotation<2> nearest_rotation(const PointMatrix<2>& C) {
  return Rotation<2>(std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1)));
}
Rotation<3> nearest_rotation(const PointMatrix<3>& C) {
  const Eigen::JacobiSVD<PointMatrix<3>> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // Not a reflection: the least singular direction gives way.
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  return Rotation<3>(Matrix<3>(svd.matrixU() * Point<3>(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose()));
}

}  // namespace

template <int Dim>
Pose<Dim> align(const std::vector<Point<Dim>>& from, const std::vector<Point<Dim>>& to) {
  require_same_size(from.size(), to.size());
  if (from.empty()) throw std::invalid_argument("Nothing to align");
  const Point<Dim> mean_from = mean<Dim>(from);
  const Point<Dim> mean_to = mean<Dim>(to);
  PointMatrix<Dim> covariance = PointMatrix<Dim>::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) covariance += (to[i] - mean_to) * (from[i] - mean_from).transpose();
  const Rotation<Dim> rotation = nearest_rotation(covariance);
  return {mean_to - rotation.matrix() * mean_from, rotation};
}

template <int Dim>
AbsoluteTrajectoryError<Dim> absolute_trajectory_error(const std::vector<Pose<Dim>>& estimate,
                                                       const std::vector<Pose<Dim>>& truth) {
  const Pose<Dim> alignment = align(positions(estimate), positions(truth));
  PoseErrors<Dim> errors;
  for (std::size_t i = 0; i < estimate.size(); ++i) errors.add(truth[i], compose(alignment, estimate[i]));
  return {alignment, errors.summary()};
}

template <int Dim>
PoseErrorSummary relative_pose_error(const std::vector<Pose<Dim>>& estimate, const std::vector<Pose<Dim>>& truth,
                                     std::size_t span) {
  require_same_size(estimate.size(), truth.size());
  if (span == 0) throw std::invalid_argument("A relative pose error needs a span of at least one step");
  PoseErrors<Dim> errors;
  for (std::size_t i = 0; i + span < truth.size(); ++i) {
    const Pose<Dim> true_motion = between(truth[i], truth[i + span]);
    errors.add(Pose<Dim>{}, between(true_motion, between(estimate[i], estimate[i + span])));
  }
  return errors.summary();
}

template <int Dim>
MapDifference map_difference(const GlobalMap<Dim>& a, const GlobalMap<Dim>& b) {
  PoseErrors<Dim> poses;
  std::vector<double> features;
  std::size_t unmatched = match(a.pose_ids, a.poses, b.pose_ids, b.poses,
                                [&](const Pose<Dim>& pose_a, const Pose<Dim>& pose_b) { poses.add(pose_a, pose_b); });
  unmatched += match(a.feature_ids, a.features, b.feature_ids, b.features,
                     [&](const Point<Dim>& p_a, const Point<Dim>& p_b) { features.push_back((p_a - p_b).norm()); });
  return {poses.summary(), summary_of(features), unmatched};
}

template Pose<2> align(const std::vector<Point<2>>&, const std::vector<Point<2>>&);
template Pose<3> align(const std::vector<Point<3>>&, const std::vector<Point<3>>&);
template AbsoluteTrajectoryError<2> absolute_trajectory_error(const std::vector<Pose<2>>&, const std::vector<Pose<2>>&);
template AbsoluteTrajectoryError<3> absolute_trajectory_error(const std::vector<Pose<3>>&, const std::vector<Pose<3>>&);
template PoseErrorSummary relative_pose_error(const std::vector<Pose<2>>&, const std::vector<Pose<2>>&, std::size_t);
template PoseErrorSummary relative_pose_error(const std::vector<Pose<3>>&, const std::vector<Pose<3>>&, std::size_t);
template MapDifference map_difference(const GlobalMap<2>&, const GlobalMap<2>&);
template MapDifference map_difference(const GlobalMap<3>&, const GlobalMap<3>&);

}  // namespace mapjoin
