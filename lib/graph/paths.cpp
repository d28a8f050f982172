// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <mapjoin/graph/graph.hpp>
#include <numeric>
#include <tuple>

namespace mapjoin {
namespace {

/// The edges that form paths, each taken if it can be.
std::vector<Edge> path_edges(std::size_t vertices, const std::vector<Edge>& edges) {
  std::vector<Vertex> other_end(vertices);  // the other end of the path that each vertex ends
  std::iota(other_end.begin(), other_end.end(), Vertex{0});
  std::vector<int> degree(vertices, 0);
  std::vector<Edge> taken;
  for (const auto& [a, b] : edges) {
    if (degree[a] == 2 || degree[b] == 2 || a == b || other_end[a] == b) continue;
    const Vertex first = other_end[a];
    const Vertex last = other_end[b];
    other_end[first] = last;
    other_end[last] = first;
    ++degree[a];
    ++degree[b];
    taken.emplace_back(a, b);
  }
  return taken;
}

/// The edges with the fewest others at their vertices first, then by vertices; only repeated edges stay in their order.
std::vector<Edge> loneliest_first(std::size_t vertices, std::vector<Edge> edges) {
  std::vector<std::size_t> degree(vertices, 0);
  for (const auto& [a, b] : edges) {
    ++degree[a];
    ++degree[b];
  }
  std::ranges::stable_sort(edges, {}, [&](const Edge& edge) {
    return std::tuple(degree[edge.first] + degree[edge.second], std::min(edge.first, edge.second),
                      std::max(edge.first, edge.second));
  });
  return edges;
}

/// The starts of walks along the paths: ends that an edge leads away from, then all ends, in the order in which edges mention
/// them, then vertices on no path.
std::vector<Vertex> starts(std::size_t vertices, const std::vector<Edge>& edges, const std::vector<Edge>& taken) {
  std::vector<int> degree(vertices, 0);
  std::vector<bool> is_base(vertices, false);
  for (const auto& [a, b] : taken) {
    ++degree[a];
    ++degree[b];
    is_base[a] = true;
  }
  std::vector<Vertex> referenced;
  for (const auto& [a, b] : edges) referenced.insert(referenced.end(), {a, b});
  std::vector<Vertex> all(vertices);
  std::iota(all.begin(), all.end(), Vertex{0});
  std::vector<Vertex> starts;
  const auto add = [&](const std::vector<Vertex>& list, auto&& is_start) {
    std::copy_if(list.begin(), list.end(), std::back_inserter(starts), is_start);
  };
  add(referenced, [&](Vertex v) { return degree[v] == 1 && is_base[v]; });
  add(referenced, [&](Vertex v) { return degree[v] == 1; });
  add(all, [&](Vertex v) { return degree[v] == 0; });
  return starts;
}

}  // namespace

PathCover cover_by_paths(std::size_t vertices, const std::vector<Edge>& edges) {
  std::vector<Edge> taken = path_edges(vertices, edges);
  std::vector<Edge> others = path_edges(vertices, loneliest_first(vertices, edges));
  if (others.size() > taken.size()) taken = std::move(others);
  PathCover cover;
  cover.edges = taken.size();
  // A breadth-first search from its end walks along a path.
  for (const Reached& reached : spanning_forest(vertices, taken, starts(vertices, edges, taken))) {
    cover.order.push_back(reached.vertex);
  }
  return cover;
}

}  // namespace mapjoin
