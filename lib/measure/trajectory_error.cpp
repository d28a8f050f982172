// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <mapjoin/measure/trajectory_error.hpp>
#include <numeric>
#include <stdexcept>

namespace mapjoin {
namespace {

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

/// Calls `both(value in a, value in b)` for every id that both maps have; returns the number of ids that only one of them has.
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

/// The path length from the first pose to each.
template <int Dim>
std::vector<double> travelled(const std::vector<Pose<Dim>>& poses) {
  std::vector<double> way(poses.size(), 0.0);
  for (std::size_t i = 1; i < poses.size(); ++i) {
    way[i] = way[i - 1] + (poses[i].translation - poses[i - 1].translation).norm();
  }
  return way;
}

PosePairs nearest_by_path(const std::vector<double>& way, double metres) {
  PosePairs pairs;
  const auto miss = [&](std::size_t i, std::size_t j) { return std::abs(way[j] - way[i] - metres); };
  for (std::size_t i = 0; i + 1 < way.size(); ++i) {
    // The first of several poses at the same path length, which never decreases.
    auto j = static_cast<std::size_t>(
        std::lower_bound(way.begin() + static_cast<std::ptrdiff_t>(i) + 1, way.end(), way[i] + metres) - way.begin());
    if (j == way.size() || (j > i + 1 && miss(i, j - 1) <= miss(i, j))) {
      j = static_cast<std::size_t>(std::lower_bound(way.begin() + static_cast<std::ptrdiff_t>(i) + 1, way.end(), way[j - 1]) -
                                   way.begin());
    }
    if (miss(i, j) <= 0.1 * metres) pairs.emplace_back(i, j);
  }
  return pairs;
}

}  // namespace

Rotation<2> nearest_rotation(const PointMatrix<2>& C) {
  return Rotation<2>(std::atan2(C(1, 0) - C(0, 1), C(0, 0) + C(1, 1)));
}
Rotation<3> nearest_rotation(const PointMatrix<3>& C) {
  const Eigen::JacobiSVD<PointMatrix<3>> svd(C, Eigen::ComputeFullU | Eigen::ComputeFullV);
  // No reflection: the direction of the least singular value is reversed if necessary.
  const double sign = svd.matrixU().determinant() * svd.matrixV().determinant() < 0.0 ? -1.0 : 1.0;
  return Rotation<3>(Matrix<3>(svd.matrixU() * Point<3>(1.0, 1.0, sign).asDiagonal() * svd.matrixV().transpose()));
}

ErrorSummary summary_of(const std::vector<double>& errors) {
  if (errors.empty()) return {};
  const auto count = static_cast<double>(errors.size());
  std::vector<double> sorted = errors;
  std::ranges::sort(sorted);
  const double mean = std::accumulate(sorted.begin(), sorted.end(), 0.0) / count;
  const double squares = std::inner_product(sorted.begin(), sorted.end(), sorted.begin(), 0.0);
  const double scatter = std::accumulate(sorted.begin(), sorted.end(), 0.0,
                                         [&](double sum, double error) { return sum + (error - mean) * (error - mean); });
  const double median = 0.5 * (sorted[(sorted.size() - 1) / 2] + sorted[sorted.size() / 2]);
  return {.count = errors.size(),
          .rms = std::sqrt(squares / count),
          .max = sorted.back(),
          .mean = mean,
          .median = median,
          .min = sorted.front(),
          .deviation = std::sqrt(scatter / count)};
}

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
                                                       const std::vector<Pose<Dim>>& truth, TrajectoryAlignment alignment) {
  require_same_size(estimate.size(), truth.size());
  Pose<Dim> motion;
  if (alignment == TrajectoryAlignment::kRigid) motion = align(positions(estimate), positions(truth));
  if (alignment == TrajectoryAlignment::kOrigin) motion = compose(truth.at(0), inverse(estimate.at(0)));
  PoseErrors<Dim> errors;
  for (std::size_t i = 0; i < estimate.size(); ++i) errors.add(truth[i], compose(motion, estimate[i]));
  return {motion, errors.summary()};
}

PosePairs pairs_by_steps(std::size_t poses, std::size_t span, SpanPairs which) {
  if (span == 0) throw std::invalid_argument("A relative pose error needs a span of at least one step");
  PosePairs pairs;
  const std::size_t step = which == SpanPairs::kAll ? 1 : span;
  for (std::size_t i = 0; i + span < poses; i += step) pairs.emplace_back(i, i + span);
  return pairs;
}

template <int Dim>
PosePairs pairs_by_path(const std::vector<Pose<Dim>>& poses, double metres, SpanPairs which) {
  const std::vector<double> way = travelled(poses);
  if (which == SpanPairs::kAll) return nearest_by_path(way, metres);
  std::vector<std::size_t> ends;
  double since = 0.0;
  for (std::size_t i = 0; i < way.size(); ++i) {
    since += i == 0 ? 0.0 : way[i] - way[i - 1];
    if (since < metres) continue;
    ends.push_back(i);
    since = 0.0;
  }
  PosePairs pairs;
  for (std::size_t k = 1; k < ends.size(); ++k) pairs.emplace_back(ends[k - 1], ends[k]);
  return pairs;
}

template <int Dim>
PoseErrorSummary relative_pose_error(const std::vector<Pose<Dim>>& estimate, const std::vector<Pose<Dim>>& truth,
                                     const PosePairs& pairs) {
  require_same_size(estimate.size(), truth.size());
  PoseErrors<Dim> errors;
  for (const auto& [i, j] : pairs) {
    if (std::max(i, j) >= truth.size()) throw std::invalid_argument("A pair has a pose that is not in the trajectories");
    errors.add(Pose<Dim>{}, between(between(truth[i], truth[j]), between(estimate[i], estimate[j])));
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
template AbsoluteTrajectoryError<2> absolute_trajectory_error(const std::vector<Pose<2>>&, const std::vector<Pose<2>>&,
                                                              TrajectoryAlignment);
template AbsoluteTrajectoryError<3> absolute_trajectory_error(const std::vector<Pose<3>>&, const std::vector<Pose<3>>&,
                                                              TrajectoryAlignment);
template PosePairs pairs_by_path(const std::vector<Pose<2>>&, double, SpanPairs);
template PoseErrorSummary relative_pose_error(const std::vector<Pose<2>>&, const std::vector<Pose<2>>&, const PosePairs&);
template PosePairs pairs_by_path(const std::vector<Pose<3>>&, double, SpanPairs);
template PoseErrorSummary relative_pose_error(const std::vector<Pose<3>>&, const std::vector<Pose<3>>&, const PosePairs&);
template MapDifference map_difference(const GlobalMap<2>&, const GlobalMap<2>&);
template MapDifference map_difference(const GlobalMap<3>&, const GlobalMap<3>&);

}  // namespace mapjoin
