// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

template <typename Observations, typename Targets, typename Poses>
double sum(const Observations& observations, const Poses& poses, const Targets& targets) {
  const typename Poses::value_type world;
  return parallel_sum(observations.size(), kObservationsPerPiece, [&](std::size_t k) {
    const auto& observation = observations[k];
    const auto& base = observation.base == kWorld ? world : poses[static_cast<std::size_t>(observation.base)];
    return chi2(observation, base, targets[static_cast<std::size_t>(observation.target)]);
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
double chi2(const PoseObservation<Dim>& observation, const Pose<Dim>& base, const Pose<Dim>& target) {
  const Pose<Dim> expected = between(base, target);
  PoseVector<Dim> r;
  r << observation.measured.translation - expected.translation,
      (expected.rotation.inverse() * observation.measured.rotation).log();
  return r.dot(observation.information * r);
}

template <int Dim>
double chi2(const FeatureObservation<Dim>& observation, const Pose<Dim>& base, const Point<Dim>& target) {
  const Point<Dim> r = observation.measured - transform_into(base, target);
  return r.dot(observation.information * r);
}

template <int Dim>
Chi2 log_chi2(const Log<Dim>& log, const std::vector<Pose<Dim>>& poses, const std::vector<Point<Dim>>& features) {
  if (poses.size() != log.poses.size() || features.size() != log.features.size()) {
    throw std::invalid_argument("log_chi2: needs one pose per pose and one point per feature of the log");
  }
  return {.odometry = sum(log.odometry, poses, poses),
          .closures = sum(log.closures, poses, poses),
          .observations = sum(log.observations, poses, features),
          .priors = sum(log.pose_priors, poses, poses) + sum(log.feature_priors, poses, features)};
}

template <int Dim>
std::int64_t degrees_of_freedom(const Log<Dim>& log, std::size_t held_poses) {
  const std::int64_t rows = measured_rows(log.odometry) + measured_rows(log.closures) + measured_rows(log.observations) +
                            measured_rows(log.pose_priors) + measured_rows(log.feature_priors);
  const auto free_poses = static_cast<std::int64_t>(log.poses.size()) - static_cast<std::int64_t>(held_poses);
  return rows - free_poses * kPoseDof<Dim> - static_cast<std::int64_t>(log.features.size()) * Dim;
}

template double chi2(const PoseObservation<2>&, const Pose<2>&, const Pose<2>&);
template double chi2(const PoseObservation<3>&, const Pose<3>&, const Pose<3>&);
template double chi2(const FeatureObservation<2>&, const Pose<2>&, const Point<2>&);
template double chi2(const FeatureObservation<3>&, const Pose<3>&, const Point<3>&);
template Chi2 log_chi2(const Log<2>&, const std::vector<Pose<2>>&, const std::vector<Point<2>>&);
template Chi2 log_chi2(const Log<3>&, const std::vector<Pose<3>>&, const std::vector<Point<3>>&);
template std::int64_t degrees_of_freedom(const Log<2>&, std::size_t);
template std::int64_t degrees_of_freedom(const Log<3>&, std::size_t);

}  // namespace mapjoin
