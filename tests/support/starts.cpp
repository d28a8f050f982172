// SPDX-License-Identifier: BSD-3-Clause
#include <queue>
#include <tests/support/starts.hpp>

namespace mapjoin::testing {
namespace {

template <int Dim>
struct Edge {
  PoseIndex base;
  PoseIndex target;
  Pose<Dim> measured;
};
template <int Dim>
struct Seen {
  PoseIndex base;
  FeatureIndex feature;
  Point<Dim> measured;
};

template <int Dim>
void append(std::vector<Edge<Dim>>& edges, std::type_identity_t<std::span<const PoseFactor<Dim>>> observations) {
  for (const auto& o : observations) {
    if (o.base != kWorld) edges.push_back({o.base, o.target, o.measured});
  }
}
template <int Dim>
void append(std::vector<Seen<Dim>>& observations_seen, std::type_identity_t<std::span<const FeatureFactor<Dim>>> observations) {
  for (const auto& o : observations) observations_seen.push_back({o.base, o.target, o.measured});
}

/// Poses composed along the edges, breadth-first and in their order: from all fixed poses, then from each pose not reached yet,
/// which is placed at the origin.
template <int Dim>
Table<PoseIndex, Pose<Dim>> spread(std::size_t count, const std::vector<FixedPose<Dim>>& fixed,
                                   const std::vector<Edge<Dim>>& edges) {
  Table<PoseIndex, std::vector<const Edge<Dim>*>> incident(count);
  for (const Edge<Dim>& edge : edges) {
    incident[edge.base].push_back(&edge);
    incident[edge.target].push_back(&edge);
  }
  Table<PoseIndex, Pose<Dim>> poses(count);
  Table<PoseIndex, bool> reached(count);
  std::queue<PoseIndex> front;
  const auto reach = [&](PoseIndex i, const Pose<Dim>& pose) {
    if (reached[i]) return;
    reached[i] = true;
    poses[i] = pose;
    front.push(i);
  };
  const auto drain = [&] {
    for (; !front.empty(); front.pop()) {
      const PoseIndex i = front.front();
      for (const Edge<Dim>* edge : incident[i]) {
        if (edge->base == i) reach(edge->target, compose(poses[i], edge->measured));
        if (edge->target == i) reach(edge->base, compose(poses[i], inverse(edge->measured)));
      }
    }
  };
  for (const FixedPose<Dim>& pose : fixed) reach(pose.pose, pose.value);
  drain();
  for (const PoseIndex i : indices(poses)) {
    reach(i, Pose<Dim>{});
    drain();
  }
  return poses;
}

template <int Dim>
Values<Dim> with_first_observations(Table<PoseIndex, Pose<Dim>> poses, std::size_t count,
                                    const std::vector<Seen<Dim>>& observations_seen) {
  Table<FeatureIndex, Point<Dim>> features(count, Point<Dim>::Zero());
  Table<FeatureIndex, bool> placed(count);
  for (const Seen<Dim>& seen : observations_seen) {
    if (placed[seen.feature]) continue;
    placed[seen.feature] = true;
    const Pose<Dim> base = seen.base == kWorld ? Pose<Dim>{} : poses[seen.base];
    features[seen.feature] = transform(base, seen.measured);
  }
  return {std::move(poses), std::move(features)};
}

}  // namespace

template <int Dim>
Values<Dim> with_first_observations(const Log<Dim>& log, Table<PoseIndex, Pose<Dim>> poses) {
  std::vector<Seen<Dim>> observations_seen;
  append(observations_seen, log.graph.feature_factors);
  return with_first_observations(std::move(poses), log.features.size(), observations_seen);
}

template <int Dim>
Values<Dim> with_first_observations(const SubmapSet<Dim>& set, Table<PoseIndex, Pose<Dim>> poses) {
  std::vector<Seen<Dim>> observations_seen;
  for (const LocalMap<Dim>& map : set.graph.submaps) {
    for (std::size_t i = 0; i < map.features.size(); ++i) {
      observations_seen.push_back({map.base, map.features[i], map.feature_estimates[i]});
    }
  }
  append(observations_seen, set.graph.feature_factors);
  return with_first_observations(std::move(poses), set.features.size(), observations_seen);
}

template <int Dim>
Values<Dim> composed_start(const SubmapSet<Dim>& set) {
  std::vector<Edge<Dim>> edges;
  for (const LocalMap<Dim>& map : set.graph.submaps) {
    if (map.base == kWorld) continue;
    for (std::size_t i = 0; i < map.poses.size(); ++i) edges.push_back({map.base, map.poses[i], map.pose_estimates[i]});
  }
  append(edges, set.graph.pose_factors);
  return with_first_observations(set, spread(set.poses.size(), set.graph.fixed, edges));
}

template <int Dim>
Values<Dim> odometry_start(const Log<Dim>& log) {
  std::vector<Edge<Dim>> edges;
  append(edges, log.odometry());
  return with_first_observations(log, spread(log.poses.size(), log.graph.fixed, edges));
}

template <int Dim>
Values<Dim> spanning_tree_start(const Log<Dim>& log) {
  std::vector<Edge<Dim>> edges;
  append(edges, log.edges());
  return with_first_observations(log, spread(log.poses.size(), log.graph.fixed, edges));
}

template <int Dim>
std::optional<Values<Dim>> file_start(const Log<Dim>& log) {
  if (log.initial.poses.empty()) return std::nullopt;
  if (log.initial.features.empty()) return with_first_observations(log, log.initial.poses);
  return Values<Dim>{log.initial.poses, log.initial.features};
}

template Values<2> with_first_observations(const Log<2>&, Table<PoseIndex, Pose<2>>);
template Values<3> with_first_observations(const Log<3>&, Table<PoseIndex, Pose<3>>);
template Values<2> with_first_observations(const SubmapSet<2>&, Table<PoseIndex, Pose<2>>);
template Values<3> with_first_observations(const SubmapSet<3>&, Table<PoseIndex, Pose<3>>);
template Values<2> composed_start(const SubmapSet<2>&);
template Values<3> composed_start(const SubmapSet<3>&);
template Values<2> odometry_start(const Log<2>&);
template Values<3> odometry_start(const Log<3>&);
template Values<2> spanning_tree_start(const Log<2>&);
template Values<3> spanning_tree_start(const Log<3>&);
template std::optional<Values<2>> file_start(const Log<2>&);
template std::optional<Values<3>> file_start(const Log<3>&);

}  // namespace mapjoin::testing
