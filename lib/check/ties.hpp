// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Logs and sets of maps as graphs: the ties between poses, features and the World.

#include <algorithm>
#include <cstddef>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// The vertices of a log or a set of maps as a graph: the World, then the poses, then the features.
struct TieVertices {
  static constexpr std::size_t kWorldVertex = 0;

  std::size_t poses = 0;
  std::size_t features = 0;

  std::size_t size() const { return 1 + poses + features; }
  std::size_t pose(PoseIndex index) const { return (index + 1).position(); }
  std::size_t feature(FeatureIndex index) const { return 1 + poses + index.position(); }
  bool is_feature(std::size_t vertex) const { return vertex > poses; }
  /// The index of a vertex that is a feature.
  FeatureIndex feature_at(std::size_t vertex) const { return FeatureIndex(vertex - 1 - poses); }
};
static_assert(kWorld == -1, "the World is the pose before the first");

/// The vertices of a log or a set of maps.
template <typename Tied>
TieVertices vertices_of(const Tied& tied) {
  return {tied.poses.size(), tied.features.size()};
}

/// The name of a vertex, "the World", "pose 17" or "feature 3". `names` is the log or the set.
template <typename Names>
std::string name_of(std::size_t vertex, const Names& names) {
  if (vertex == TieVertices::kWorldVertex) return "the World";
  const TieVertices of = vertices_of(names);
  return of.is_feature(vertex) ? to_string(names.features[of.feature_at(vertex)])
                               : to_string(names.poses[PoseIndex(vertex - 1)]);
}

/// Calls `tie(a, b)` with the two vertices of every factor of a log or a set of maps; a submap ties its base to each of its
/// targets, the World is tied to all fixed poses.
template <typename Data, typename Tie>
void for_each_tie(const Data& data, Tie&& tie) {
  const TieVertices of = vertices_of(data);
  for (const auto& map : data.graph.submaps) {
    for (const PoseIndex pose : map.poses) tie(of.pose(map.base), of.pose(pose));
    for (const FeatureIndex feature : map.features) tie(of.pose(map.base), of.feature(feature));
  }
  for (const auto& o : data.graph.pose_factors) tie(of.pose(o.base), of.pose(o.target));
  for (const auto& o : data.graph.feature_factors) tie(of.pose(o.base), of.feature(o.target));
  for (const auto& fixed : data.graph.fixed) tie(of.pose(kWorld), of.pose(fixed.pose));
}

/// The two vertices of every tie (for_each_tie).
template <typename Tied>
std::vector<Edge> ties_of(const Tied& tied) {
  std::vector<Edge> ties;
  for_each_tie(tied, [&](std::size_t a, std::size_t b) { ties.emplace_back(static_cast<Vertex>(a), static_cast<Vertex>(b)); });
  return ties;
}

/// True if a log has poses, not all of them fixed, but nothing that measures any, as a trajectory or a table of poses has.
template <int Dim>
bool has_values_only(const Log<Dim>& log) {
  const auto& graph = log.graph;
  return log.poses.size() > std::max(graph.fixed.size(), std::size_t{1}) && graph.pose_factors.empty() &&
         graph.feature_factors.empty();
}
/// What is said of such a log.
inline constexpr const char* kValuesOnly =
    "has poses, but no edges: a trajectory or a map without them, not a log; `mapjoin plot`, `mapjoin convert` and `mapjoin "
    "error` take it";

/// The names in a log or a set of maps, or in one that is spread over ranks.
struct Names {
  const std::string& source;
  const PoseIds& poses;
  const FeatureIds& features;
};

/// Performs check_connected() on edges between TieVertices; `advice` ends the message if there are several components.
Expected<void> check_tied(const Names& names, const std::vector<Edge>& ties, const std::string& advice);

/// The first pose of each connected component, or the feature of one without poses.
inline std::vector<std::size_t> component_roots(const Graph& graph) {
  const std::vector<std::uint32_t> component = components_of(graph);
  std::vector<bool> is_known(component.size());
  std::vector<std::size_t> roots;
  for (std::size_t v = TieVertices::kWorldVertex + 1; v < component.size(); ++v) {
    if (!is_known[component[v]]) roots.push_back(v);
    is_known[component[v]] = true;
  }
  return roots;
}

}  // namespace mapjoin
