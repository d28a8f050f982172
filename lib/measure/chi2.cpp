// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

template <int Dim>
const Pose<Dim>& value_of(const PoseFactor<Dim>& o, const Values<Dim>& values) {
  return values.poses[o.target];
}
template <int Dim>
const Point<Dim>& value_of(const FeatureFactor<Dim>& o, const Values<Dim>& values) {
  return values.features[o.target];
}

template <int Dim, template <int> typename Observation>
double sum(std::span<const Observation<Dim>> observations, const Values<Dim>& values) {
  return parallel_sum(observations.size(), kObservationsPerPiece, [&](std::size_t k) {
    const Observation<Dim>& o = observations[k];
    return cost(o, values.pose(o.base), value_of(o, values));
  });
}

template <typename Observations>
std::int64_t measured_rows(const Observations& observations) {
  return static_cast<std::int64_t>(parallel_sum(observations.size(), kObservationsPerPiece, [&](std::size_t k) {
    return static_cast<double>(information_rank(observations[k].information));
  }));
}

}  // namespace

template <int Dim>
Chi2 log_chi2(const Log<Dim>& log, const Values<Dim>& values) {
  if (values.poses.size() != log.poses.size() || values.features.size() != log.features.size()) {
    throw std::invalid_argument("log_chi2: needs one pose per pose and one point per feature of the log");
  }
  return {.odometry = sum(log.odometry(), values),
          .closures = sum(log.closures(), values),
          .observations = sum(log.observations(), values),
          .priors = sum(log.pose_priors(), values) + sum(log.feature_priors(), values)};
}

template <int Dim>
double graph_chi2(const FactorGraph<Dim>& graph, const Values<Dim>& values) {
  return sum<Dim, PoseFactor>(graph.pose_factors, values) + sum<Dim, FeatureFactor>(graph.feature_factors, values);
}

template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log, std::size_t held_poses) {
  const std::int64_t rows = measured_rows(log.graph.pose_factors) + measured_rows(log.graph.feature_factors);
  const auto free_poses = static_cast<std::int64_t>(log.poses.size()) - static_cast<std::int64_t>(held_poses);
  return rows - free_poses * kPoseDof<Dim> - static_cast<std::int64_t>(log.features.size()) * Dim;
}

template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log) {
  return degrees_of_freedom(log, log.is_held() ? log.graph.fixed.size() : 1);
}

template Chi2 log_chi2(const Log<2>&, const Values<2>&);
template Chi2 log_chi2(const Log<3>&, const Values<3>&);
template double graph_chi2(const FactorGraph<2>&, const Values<2>&);
template double graph_chi2(const FactorGraph<3>&, const Values<3>&);
template std::int64_t degrees_of_freedom(const Log<2>&, std::size_t);
template std::int64_t degrees_of_freedom(const Log<3>&, std::size_t);
template std::int64_t degrees_of_freedom(const Log<2>&);
template std::int64_t degrees_of_freedom(const Log<3>&);

}  // namespace mapjoin
