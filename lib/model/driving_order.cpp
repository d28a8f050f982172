// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/renumber.hpp>
#include <numeric>
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

/// How many of the poses in an order an edge ties to the one before.
std::size_t tied_steps(const std::vector<Edge>& edges, const std::vector<Vertex>& order) {
  std::vector<std::size_t> place(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) place[order[i]] = i;
  std::vector<bool> is_tied(order.size());
  for (const auto& [from, to] : edges) {
    const auto [first, second] = std::minmax(place[from], place[to]);
    if (second == first + 1) is_tied[second] = true;
  }
  return static_cast<std::size_t>(std::count(is_tied.begin(), is_tied.end(), true));
}

std::vector<Vertex> order_of_ids(std::size_t poses) {
  std::vector<Vertex> order(poses);
  std::iota(order.begin(), order.end(), Vertex{0});
  return order;
}

/// As edges name the poses for the first time; those that none names are last.
std::vector<Vertex> order_of_mention(const std::vector<Edge>& edges, std::size_t poses) {
  std::vector<std::size_t> mentioned(poses, 2 * edges.size());
  for (std::size_t k = edges.size(); k-- > 0;) {
    mentioned[edges[k].second] = 2 * k + 1;
    mentioned[edges[k].first] = 2 * k;
  }
  std::vector<Vertex> order = order_of_ids(poses);
  std::ranges::stable_sort(order, {}, [&](Vertex pose) { return mentioned[pose]; });
  return order;
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

/// In this order within each of the user's sessions.
template <int Dim>
void renumber_within_sessions(const std::vector<Vertex>& poses, Log<Dim>& log) {
  std::vector<PoseIndex> order(poses.begin(), poses.end());
  std::ranges::stable_sort(order, {}, [&](PoseIndex pose) { return log.poses[pose].session; });
  renumber_poses(order, log);
}

}  // namespace

template <int Dim>
Expected<void> take_order(const PoseIds& order, Log<Dim>& log) {
  if (order == log.poses) return {};
  const IndexOf index_of(order);
  std::vector<PoseIndex> taken(log.poses.size());
  for (const PoseIndex pose : indices(log.poses)) {
    const auto place = index_of(log.poses[pose]);
    if (!place || order.size() != log.poses.size()) return bad_input("the order of poses does not name each of them once");
    taken[place->position()] = pose;
  }
  renumber_poses(taken, log);
  return {};
}

template <int Dim>
void take_order_of_edges(Log<Dim>& log) {
  const std::size_t half = log.poses.size() / 2;
  const std::vector<Edge> edges = edges_within_sessions(log);
  const std::size_t tied_by_ids = tied_steps(edges, order_of_ids(log.poses.size()));
  if (tied_by_ids >= half) {
    const std::vector<Vertex> order = order_of_mention(edges, log.poses.size());
    if (tied_steps(edges, order) > tied_by_ids) renumber_within_sessions(order, log);
    return;
  }
  const PathCover cover = cover_by_paths(log.poses.size(), edges);
  if (cover.edges >= half) renumber_within_sessions(cover.order, log);
}

template Expected<void> take_order(const PoseIds&, Log<2>&);
template Expected<void> take_order(const PoseIds&, Log<3>&);
template void take_order_of_edges(Log<2>&);
template void take_order_of_edges(Log<3>&);

}  // namespace mapjoin
