// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/repeated_edges.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// `items` in the stable order of `key(item)`, a number in [0, keys). O(items + keys).
template <typename T, typename Key>
std::vector<T> sorted_by(Key key, std::size_t keys, std::vector<T> items) {
  const auto less = [&](const T& a, const T& b) { return key(a) < key(b); };
  if (std::is_sorted(items.begin(), items.end(), less)) return items;
  std::vector<std::size_t> next(keys + 1);  // Where the next item of each key goes.
  for (const T& item : items) ++next[key(item) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<T> sorted(items.size());
  for (const T& item : items) sorted[next[key(item)]++] = item;
  return sorted;
}

template <typename Observation>
bool is_prior(const Observation& observation) {
  return observation.base == kWorld;
}

/// An edge between successive poses of one of the user's sessions.
template <int Dim>
bool is_odometry(const PoseFactor<Dim>& edge, const PoseIds& poses) {
  const auto [first, second] = std::minmax(edge.base, edge.target);
  return !is_prior(edge) && second == first + 1 && poses[first].session == poses[second].session;
}

/// Odometry by its later pose, then closures, then priors.
template <int Dim>
void sort_pose_factors(Log<Dim>& log) {
  const std::size_t poses = log.poses.size();
  const auto key = [&](const PoseFactor<Dim>& edge) {
    return is_prior(edge) ? poses + 1 : is_odometry(edge, log.poses) ? later_pose(edge).position() : poses;
  };
  log.graph.pose_factors = sorted_by(key, poses + 2, std::move(log.graph.pose_factors));
}

/// Observations by their pose, then priors.
template <int Dim>
void sort_feature_factors(Log<Dim>& log) {
  const std::size_t poses = log.poses.size();
  const auto key = [&](const FeatureFactor<Dim>& o) { return is_prior(o) ? poses : o.base.position(); };
  log.graph.feature_factors = sorted_by(key, poses + 1, std::move(log.graph.feature_factors));
}

/// The factors whose base is the World, which stand last.
template <typename Observation>
std::span<const Observation> priors_of(const std::vector<Observation>& factors) {
  const auto begin = std::partition_point(factors.begin(), factors.end(), [](const auto& factor) { return !is_prior(factor); });
  return {begin, factors.end()};
}

/// Poses that odometry ties to their predecessor belong to its session, every other one starts a session.
template <int Dim>
std::vector<Session> sessions_of(const Log<Dim>& log) {
  std::vector<Session> sessions{{0, 1}};
  const auto odometry = log.odometry();
  auto edge = odometry.begin();
  for (PoseIndex pose = 1; pose < PoseIndex(log.poses.size()); ++pose) {
    while (edge != odometry.end() && later_pose(*edge) < pose) ++edge;
    const bool tied = edge != odometry.end() && later_pose(*edge) == pose;
    if (!tied) sessions.push_back({pose, pose});
    sessions.back().end = pose + 1;
  }
  return sessions;
}

}  // namespace

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::edges() const {
  return std::span(graph.pose_factors).first(graph.pose_factors.size() - pose_priors().size());
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::odometry() const {
  const auto end = std::partition_point(graph.pose_factors.begin(), graph.pose_factors.end(),
                                        [&](const auto& edge) { return is_odometry(edge, poses); });
  return {graph.pose_factors.begin(), end};
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::closures() const {
  return edges().subspan(odometry().size());
}

template <int Dim>
std::span<const PoseFactor<Dim>> Log<Dim>::pose_priors() const {
  return priors_of(graph.pose_factors);
}

template <int Dim>
std::span<const FeatureFactor<Dim>> Log<Dim>::observations() const {
  return std::span(graph.feature_factors).first(graph.feature_factors.size() - feature_priors().size());
}

template <int Dim>
std::span<const FeatureFactor<Dim>> Log<Dim>::feature_priors() const {
  return priors_of(graph.feature_factors);
}

template <int Dim>
void put_in_order(Log<Dim>& log) {
  sort_pose_factors(log);
  sort_feature_factors(log);
  log.repeated_edges = count_repeated(log.edges());
  log.sessions = sessions_of(log);
}

template struct Log<2>;
template struct Log<3>;
template void put_in_order(Log<2>&);
template void put_in_order(Log<3>&);

}  // namespace mapjoin
