// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/renumber.hpp>
#include <numeric>
#include <optional>
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

/// The place of each pose in an order.
std::vector<std::size_t> places_in(const std::vector<Vertex>& order) {
  std::vector<std::size_t> places(order.size());
  for (std::size_t i = 0; i < order.size(); ++i) places[order[i]] = i;
  return places;
}

/// The number of poses in an order that an edge ties to the one before.
std::size_t tied_steps(const std::vector<Edge>& edges, const std::vector<Vertex>& order) {
  const std::vector<std::size_t> place = places_in(order);
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

/// The order in which edges first name the poses, within each of the user's sessions; poses that no edge names are last.
std::vector<Vertex> order_of_mention(const std::vector<Edge>& edges, const PoseIds& poses) {
  std::vector<std::size_t> mentioned(poses.size(), 2 * edges.size());
  for (std::size_t k = edges.size(); k-- > 0;) {
    mentioned[edges[k].second] = 2 * k + 1;
    mentioned[edges[k].first] = 2 * k;
  }
  std::vector<Vertex> order = order_of_ids(poses.size());
  std::ranges::stable_sort(order, {}, [&](Vertex pose) { return std::pair(poses[PoseIndex(pose)].session, mentioned[pose]); });
  return order;
}

/// The edges along an order, by their later pose, then the others.
std::vector<Edge> along_first(std::vector<Edge> edges, const std::vector<Vertex>& order) {
  const std::vector<std::size_t> place = places_in(order);
  std::ranges::stable_sort(edges, {}, [&](const Edge& edge) {
    const auto [first, second] = std::minmax(place[edge.first], place[edge.second]);
    return second == first + 1 ? second : order.size();
  });
  return edges;
}

/// The number of steps from pose to pose within the user's sessions.
std::size_t steps_of(const PoseIds& poses) {
  std::size_t steps = 0;
  for (std::size_t i = 1; i < poses.size(); ++i) {
    if (poses[PoseIndex(i)].session == poses[PoseIndex(i - 1)].session) ++steps;
  }
  return steps;
}

/// The order of mention, if it leaves at most half as many steps untied as the ids; poses that would cut a drive go behind the
/// drives.
std::optional<std::vector<Vertex>> better_order_of_mention(const std::vector<Edge>& edges, const PoseIds& poses,
                                                           std::size_t tied_by_ids) {
  const std::size_t steps = steps_of(poses);
  if (tied_by_ids == steps) return std::nullopt;
  const auto order = order_of_mention(along_first(edges, order_of_mention(edges, poses)), poses);
  const bool is_better = 2 * (steps - tied_steps(edges, order)) <= steps - tied_by_ids;
  return is_better ? std::optional(order) : std::nullopt;
}

/// The order of paths along the edges, within each of the user's sessions, if these tie half of the poses or more.
std::optional<std::vector<Vertex>> order_of_paths(const std::vector<Edge>& edges, const PoseIds& poses) {
  PathCover cover = cover_by_paths(poses.size(), edges);
  if (cover.edges < poses.size() / 2) return std::nullopt;
  std::ranges::stable_sort(cover.order, {}, [&](Vertex pose) { return poses[PoseIndex(pose)].session; });
  return std::move(cover.order);
}

/// The order of driving that the edges tell: that of mention or of paths or, if neither is better, that of the ids.
std::vector<Vertex> order_told_by(const std::vector<Edge>& edges, const PoseIds& poses) {
  const std::vector<Vertex> of_ids = order_of_ids(poses.size());
  const std::size_t tied_by_ids = tied_steps(edges, of_ids);
  const bool do_ids_tell = tied_by_ids >= poses.size() / 2;
  return (do_ids_tell ? better_order_of_mention(edges, poses, tied_by_ids) : order_of_paths(edges, poses)).value_or(of_ids);
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
Expected<void> take_order(const PoseIds& order, Log<Dim>& log) {
  if (order == log.poses) return {};
  PoseIds named = order;
  std::ranges::sort(named);
  if (named != log.poses) return bad_input("the order of poses does not name each of them once");
  std::vector<PoseIndex> taken;
  for (const PoseId& id : order) taken.emplace_back(*find_ascending(log.poses, id));
  renumber_poses(taken, log);
  return {};
}

template <int Dim>
void take_order_of_edges(Log<Dim>& log) {
  constexpr int kMostRounds = 8;
  const std::vector<Edge> edges = edges_within_sessions(log);
  const std::vector<Vertex> of_ids = order_of_ids(log.poses.size());
  std::vector<Vertex> before;
  std::vector<Vertex> order = order_told_by(edges, log.poses);
  // Edges along the order come first where the log is written, and are to tell the same order when it is read again; those of
  // an order without gaps do.
  const bool has_gaps = tied_steps(edges, order) < steps_of(log.poses);
  for (int round = 0; has_gaps && order != before && round < kMostRounds; ++round) {
    before = std::exchange(order, order_told_by(along_first(edges, order), log.poses));
  }
  if (order != of_ids) renumber_poses<Dim>({order.begin(), order.end()}, log);
}

template Expected<void> take_order(const PoseIds&, Log<2>&);
template Expected<void> take_order(const PoseIds&, Log<3>&);
template void take_order_of_edges(Log<2>&);
template void take_order_of_edges(Log<3>&);

}  // namespace mapjoin
