// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/graph/paths.hpp>
#include <mapjoin/model/log.hpp>
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
  for (const T& item : items) ++next[static_cast<std::size_t>(key(item)) + 1];
  std::partial_sum(next.begin(), next.end(), next.begin());
  std::vector<T> sorted(items.size());
  for (const T& item : items) sorted[next[static_cast<std::size_t>(key(item))]++] = item;
  return sorted;
}

/// An edge between successive poses of one of the user's sessions.
template <int Dim>
bool is_odometry(const PoseObservation<Dim>& edge, const std::vector<PoseId>& poses) {
  const Index first = std::min(edge.base, edge.target);
  const Index second = std::max(edge.base, edge.target);
  return second == first + 1 &&
         poses[static_cast<std::size_t>(first)].session == poses[static_cast<std::size_t>(second)].session;
}

template <int Dim>
Index later_pose(const PoseObservation<Dim>& edge) {
  return std::max(edge.base, edge.target);
}

/// The number of edges beyond the first between the same two poses, whatever their direction.
template <int Dim>
std::int64_t count_repeated(const std::vector<PoseObservation<Dim>>& edges) {
  std::vector<std::pair<Index, Index>> ends;
  ends.reserve(edges.size());
  for (const auto& edge : edges) ends.emplace_back(std::minmax(edge.base, edge.target));
  std::sort(ends.begin(), ends.end());
  return ends.end() - std::unique(ends.begin(), ends.end());
}

/// Parts log.odometry, which holds all edges, into odometry and closures.
template <int Dim>
void part_edges(Log<Dim>& log) {
  auto& edges = log.odometry;
  log.repeated_edges = count_repeated(edges);
  const auto is_closure = [&](const auto& edge) { return !is_odometry(edge, log.poses); };
  log.closures.reserve(static_cast<std::size_t>(std::count_if(edges.begin(), edges.end(), is_closure)));
  std::copy_if(edges.begin(), edges.end(), std::back_inserter(log.closures), is_closure);
  std::erase_if(edges, is_closure);
  edges = sorted_by(later_pose<Dim>, log.poses.size(), std::move(edges));
}

/// How many poses an edge ties to the one before.
template <int Dim>
std::size_t tied_steps(const Log<Dim>& log) {
  std::vector<bool> is_tied(log.poses.size(), false);
  for (const auto& edge : log.odometry) {
    if (is_odometry(edge, log.poses)) is_tied[static_cast<std::size_t>(later_pose(edge))] = true;
  }
  return static_cast<std::size_t>(std::count(is_tied.begin(), is_tied.end(), true));
}

/// The edges between poses of one of the user's sessions.
template <int Dim>
std::vector<Edge> edges_within_sessions(const Log<Dim>& log) {
  std::vector<Edge> edges;
  for (const auto& edge : log.odometry) {
    const auto base = static_cast<Vertex>(edge.base);
    const auto target = static_cast<Vertex>(edge.target);
    if (log.poses[base].session == log.poses[target].session) edges.emplace_back(base, target);
  }
  return edges;
}

template <typename T>
void permute(const std::vector<Vertex>& order, std::vector<T>& values) {
  if (values.empty()) return;
  std::vector<T> permuted;
  for (const Vertex v : order) permuted.push_back(values[v]);
  values = std::move(permuted);
}

/// Gives the poses new indices: order[i] becomes i.
template <int Dim>
void renumber_poses(const std::vector<Vertex>& order, Log<Dim>& log) {
  std::vector<Index> index(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) index[order[i]] = static_cast<Index>(i);
  const auto renumber = [&](Index& pose) {
    if (pose != kWorld) pose = index[static_cast<std::size_t>(pose)];
  };
  for (auto* edges : {&log.odometry, &log.pose_priors}) {
    for (auto& edge : *edges) {
      renumber(edge.base);
      renumber(edge.target);
    }
  }
  for (auto& observation : log.observations) renumber(observation.base);
  for (auto& fixed : log.fixed) renumber(fixed.pose);
  std::ranges::sort(log.fixed, {}, &FixedPose<Dim>::pose);
  permute(order, log.poses);
  permute(order, log.initial_poses);
  permute(order, log.stamps_ns);
}

/// Poses that odometry ties to their predecessor belong to its session, every other one starts a session.
template <int Dim>
std::vector<Session> sessions_of(const Log<Dim>& log) {
  std::vector<Session> sessions{{0, 1}};
  auto edge = log.odometry.begin();
  for (Index pose = 1; pose < static_cast<Index>(log.poses.size()); ++pose) {
    while (edge != log.odometry.end() && later_pose(*edge) < pose) ++edge;
    const bool tied = edge != log.odometry.end() && later_pose(*edge) == pose;
    if (!tied) sessions.push_back({pose, pose});
    sessions.back().end = pose + 1;
  }
  return sessions;
}

}  // namespace

template <int Dim>
void take_order_of_edges(Log<Dim>& log) {
  const std::size_t half = log.poses.size() / 2;
  if (tied_steps(log) >= half) return;
  PathCover cover = cover_by_paths(log.poses.size(), edges_within_sessions(log));
  if (cover.edges < half) return;
  std::ranges::stable_sort(cover.order, {}, [&](Vertex v) { return log.poses[v].session; });
  renumber_poses(cover.order, log);
}

template <int Dim>
void put_in_order(Log<Dim>& log) {
  part_edges(log);
  log.observations = sorted_by([](const auto& o) { return o.base; }, log.poses.size(), std::move(log.observations));
  log.sessions = sessions_of(log);
}

template <int Dim>
void use_identity_covariance(Log<Dim>& log) {
  for (auto* edges : {&log.odometry, &log.closures, &log.pose_priors}) {
    for (auto& edge : *edges) edge.information.setIdentity();
  }
  for (auto* observations : {&log.observations, &log.feature_priors}) {
    for (auto& observation : *observations) observation.information.setIdentity();
  }
  log.conventions.covariance = Covariance::kIdentity;
}

template void take_order_of_edges(Log<2>&);
template void take_order_of_edges(Log<3>&);
template void put_in_order(Log<2>&);
template void put_in_order(Log<3>&);
template void use_identity_covariance(Log<2>&);
template void use_identity_covariance(Log<3>&);

}  // namespace mapjoin
