// SPDX-License-Identifier: BSD-3-Clause
#include <queue>
#include <tests/support/starts.hpp>

namespace mapjoin::testing {
namespace {

template <typename T>
decltype(auto) at(T& values, Index i) {
  return values[static_cast<std::size_t>(i)];
}

/// The edges at every pose, in the order in which they are given.
template <int Dim>
std::vector<std::vector<const PoseObservation<Dim>*>> incident_edges(
    std::size_t poses, std::initializer_list<const std::vector<PoseObservation<Dim>>*> lists) {
  std::vector<std::vector<const PoseObservation<Dim>*>> incident(poses);
  for (const auto* list : lists) {
    for (const PoseObservation<Dim>& edge : *list) {
      at(incident, edge.base).push_back(&edge);
      at(incident, edge.target).push_back(&edge);
    }
  }
  return incident;
}

/// Breadth-first from each fixed pose in turn, then from every pose not reached yet, which goes to the origin.
template <int Dim>
State<Dim> spread(const Log<Dim>& log, std::initializer_list<const std::vector<PoseObservation<Dim>>*> lists) {
  const auto incident = incident_edges<Dim>(log.poses.size(), lists);
  std::vector<Pose<Dim>> poses(log.poses.size());
  std::vector<bool> reached(log.poses.size());
  std::queue<Index> front;
  const auto reach = [&](Index i, const Pose<Dim>& pose) {
    if (at(reached, i)) return;
    at(reached, i) = true;
    at(poses, i) = pose;
    front.push(i);
  };
  const auto drain = [&] {
    for (; !front.empty(); front.pop()) {
      const Index i = front.front();
      for (const PoseObservation<Dim>* edge : at(incident, i)) {
        if (edge->base == i) reach(edge->target, compose(at(poses, i), edge->measured));
        if (edge->target == i) reach(edge->base, compose(at(poses, i), inverse(edge->measured)));
      }
    }
  };
  for (const FixedPose<Dim>& fixed : log.fixed) {
    reach(fixed.pose, fixed.value);
    drain();
  }
  for (Index i = 0; i < static_cast<Index>(poses.size()); ++i) {
    reach(i, Pose<Dim>{});
    drain();
  }
  for (const FixedPose<Dim>& fixed : log.fixed) at(poses, fixed.pose) = fixed.value;
  return with_first_observations(log, std::move(poses));
}

}  // namespace

template <int Dim>
State<Dim> with_first_observations(const Log<Dim>& log, std::vector<Pose<Dim>> poses) {
  std::vector<Point<Dim>> features(log.features.size(), Point<Dim>::Zero());
  std::vector<bool> placed(features.size());
  const auto place = [&](const FeatureObservation<Dim>& observation) {
    if (at(placed, observation.target)) return;
    at(placed, observation.target) = true;
    const Pose<Dim> base = observation.base == kWorld ? Pose<Dim>{} : at(poses, observation.base);
    at(features, observation.target) = transform(base, observation.measured);
  };
  for (const auto& observation : log.observations) place(observation);
  for (const auto& prior : log.feature_priors) place(prior);
  return {std::move(poses), std::move(features)};
}

template <int Dim>
State<Dim> odometry_start(const Log<Dim>& log) {
  return spread<Dim>(log, {&log.odometry});
}

template <int Dim>
State<Dim> spanning_tree_start(const Log<Dim>& log) {
  return spread<Dim>(log, {&log.odometry, &log.closures});
}

template <int Dim>
std::optional<State<Dim>> file_start(const Log<Dim>& log) {
  if (log.initial_poses.empty()) return std::nullopt;
  if (log.initial_features.empty()) return with_first_observations(log, log.initial_poses);
  return State<Dim>{log.initial_poses, log.initial_features};
}

template State<2> with_first_observations(const Log<2>&, std::vector<Pose<2>>);
template State<3> with_first_observations(const Log<3>&, std::vector<Pose<3>>);
template State<2> odometry_start(const Log<2>&);
template State<3> odometry_start(const Log<3>&);
template State<2> spanning_tree_start(const Log<2>&);
template State<3> spanning_tree_start(const Log<3>&);
template std::optional<State<2>> file_start(const Log<2>&);
template std::optional<State<3>> file_start(const Log<3>&);

}  // namespace mapjoin::testing
