// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <boost/graph/biconnected_components.hpp>
#include <boost/graph/core_numbers.hpp>
#include <iterator>
#include <limits>
#include <map>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/check/weak_links.hpp>
#include <mapjoin/model/lists.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The ties as edges of a graph without loops, sorted, the smaller end first.
template <typename Tied>
std::vector<Edge> sorted_ties(const Tied& tied) {
  std::vector<Edge> ties = ties_of(tied);
  for (auto& [first, second] : ties) {
    if (first > second) std::swap(first, second);
  }
  std::ranges::sort(ties);
  return ties;
}

/// The degree of each vertex within the 2-core of the graph (what remains after vertices with one edge are removed repeatedly):
/// 0, or 2 and more.
std::vector<std::size_t> core_degrees(const Graph& graph) {
  std::vector<std::size_t> core(num_vertices(graph));
  core_numbers(graph, boost::make_iterator_property_map(core.begin(), get(boost::vertex_index, graph)));
  std::vector<std::size_t> degree(core.size(), 0);
  for (Vertex v = 0; v < core.size(); ++v) {
    const auto [first, end] = adjacent_vertices(v, graph);
    if (core[v] >= 2) degree[v] = static_cast<std::size_t>(std::count_if(first, end, [&](Vertex u) { return core[u] >= 2; }));
  }
  return degree;
}

/// The biconnected component of every edge.
std::vector<std::size_t> edge_components(const Graph& graph, std::size_t edges) {
  std::vector<std::size_t> component(edges);
  biconnected_components(graph, boost::make_iterator_property_map(component.begin(), get(&EdgeNumber::number, graph)));
  return component;
}

/// The chains of bridges, which come in order: two are in one chain if they meet at a vertex that has no other edge.
std::vector<LoneChain> chains_of(const std::vector<Edge>& bridges, const std::vector<std::size_t>& degree) {
  std::map<std::size_t, Vertex> bridge_at;  // The first bridge at each vertex of degree 2.
  std::vector<Edge> meetings;
  for (Vertex b = 0; b < bridges.size(); ++b) {
    for (const std::size_t v : {bridges[b].first, bridges[b].second}) {
      if (degree[v] != 2) continue;
      const auto [first, is_new] = bridge_at.emplace(v, b);
      if (!is_new) meetings.emplace_back(first->second, b);
    }
  }
  const std::vector<std::uint32_t> chain_of = components_of(make_graph(bridges.size(), meetings));
  std::vector<LoneChain> chains;
  for (std::size_t b = 0; b < bridges.size(); ++b) {
    if (chain_of[b] == chains.size()) chains.push_back({bridges[b].first, 0, 0});
    LoneChain& chain = chains[chain_of[b]];
    chain.last = std::max<std::size_t>(chain.last, bridges[b].second);
    ++chain.edges;
  }
  return chains;
}

/// The features that belong to several components, edges outside of the 2-core left out.
std::vector<std::size_t> cut_features(const std::vector<Edge>& edges, const std::vector<std::size_t>& component,
                                      const std::vector<std::size_t>& degree, const TieVertices& vertices) {
  constexpr std::size_t kNone = std::numeric_limits<std::size_t>::max();
  Table<FeatureIndex, std::size_t> component_of(vertices.features, kNone);
  std::vector<std::size_t> features;
  for (std::size_t e = 0; e < edges.size(); ++e) {
    const std::size_t v = edges[e].second;  // Features come last.
    if (!vertices.is_feature(v) || degree[edges[e].first] == 0 || degree[v] == 0) continue;
    std::size_t& known = component_of[vertices.feature_at(v)];
    if (known != kNone && known != component[e]) features.push_back(v);
    known = component[e];
  }
  make_distinct(features);
  return features;
}

}  // namespace

template <typename LogOrSet>
WeakLinks weak_links(const LogOrSet& tied) {
  const TieVertices vertices = vertices_of(tied);
  const std::vector<Edge> ties = sorted_ties(tied);
  std::vector<Edge> edges;  // each once
  std::ranges::unique_copy(ties, std::back_inserter(edges));
  const Graph graph = make_graph(vertices.size(), edges);
  const std::vector<std::size_t> degree = core_degrees(graph);
  const std::vector<std::size_t> component = edge_components(graph, edges.size());
  const std::vector<bool> is_bridge = bridges_of(vertices.size(), ties);

  std::vector<Edge> bridges;
  for (std::size_t t = 0; t < ties.size(); ++t) {
    const auto [a, b] = ties[t];
    if (is_bridge[t] && !vertices.is_feature(b) && degree[a] != 0 && degree[b] != 0) bridges.push_back(ties[t]);
  }
  return {chains_of(bridges, degree), cut_features(edges, component, degree, vertices)};
}

template WeakLinks weak_links(const Log<2>&);
template WeakLinks weak_links(const Log<3>&);
template WeakLinks weak_links(const SubmapSet<2>&);
template WeakLinks weak_links(const SubmapSet<3>&);

}  // namespace mapjoin
