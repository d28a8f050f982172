// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/renumber.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The edges between poses of one of the user's sessions.
template <int Dim>
std::vector<Edge> edges_within_sessions(const Log<Dim>& log) {
  std::vector<Edge> edges;
  for (const auto& edge : log.graph.pose_factors) {
    if (edge.base == kWorld) continue;
    if (log.poses[edge.base].session != log.poses[edge.target].session) continue;
    edges.emplace_back(edge.base.position(), edge.target.position());
  }
  return edges;
}

/// How many of the poses an edge ties to the one before.
std::size_t tied_steps(const std::vector<Edge>& edges, std::size_t poses) {
  std::vector<bool> is_tied(poses);
  for (const auto& [from, to] : edges) {
    const auto [first, second] = std::minmax(from, to);
    if (second == first + 1) is_tied[second] = true;
  }
  return static_cast<std::size_t>(std::count(is_tied.begin(), is_tied.end(), true));
}

template <typename T>
void permute(const std::vector<PoseIndex>& order, Table<PoseIndex, T>& values) {
  if (values.empty()) return;
  Table<PoseIndex, T> permuted;
  for (const PoseIndex pose : order) permuted.push_back(values[pose]);
  values = std::move(permuted);
}

/// Gives the poses new indices: order[i] becomes i.
template <int Dim>
void renumber_poses(const std::vector<PoseIndex>& order, Log<Dim>& log) {
  Table<PoseIndex, PoseIndex> index(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) index[order[i]] = PoseIndex(i);
  renumber(log.graph, EachKind{[&](PoseIndex old) { return index[old]; }, [](FeatureIndex same) { return same; }});
  std::ranges::sort(log.graph.fixed, {}, &FixedPose<Dim>::pose);
  permute(order, log.poses);
  permute(order, log.initial.poses);
  permute(order, log.stamps_ns);
}

}  // namespace

template <int Dim>
void take_order_of_edges(Log<Dim>& log) {
  const std::size_t half = log.poses.size() / 2;
  const std::vector<Edge> edges = edges_within_sessions(log);
  if (tied_steps(edges, log.poses.size()) >= half) return;
  const PathCover cover = cover_by_paths(log.poses.size(), edges);
  if (cover.edges < half) return;
  std::vector<PoseIndex> order(cover.order.begin(), cover.order.end());
  std::ranges::stable_sort(order, {}, [&](PoseIndex pose) { return log.poses[pose].session; });
  renumber_poses(order, log);
}

template void take_order_of_edges(Log<2>&);
template void take_order_of_edges(Log<3>&);

}  // namespace mapjoin
