// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Undirected graphs for Boost.Graph, and what is asked of them.

#include <boost/graph/compressed_sparse_row_graph.hpp>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin {

/// A property of an edge: its number, the same in both directions.
struct EdgeNumber {
  std::uint32_t number = 0;
};

/// A compressed graph that holds every edge in both directions.
using Graph = boost::compressed_sparse_row_graph<boost::directedS, boost::no_property, EdgeNumber, boost::no_property,
                                                 std::uint32_t, std::uint32_t>;
using Vertex = std::uint32_t;
/// The two vertices of an edge.
using Edge = std::pair<Vertex, Vertex>;

/// The graph of `edges`, numbered in their order. O(vertices + edges).
Graph make_graph(std::size_t vertices, const std::vector<Edge>& edges);

/// The connected component of each vertex. Components are numbered in the order of their first vertices.
std::vector<std::uint32_t> components_of(const Graph& graph);

/// A vertex of a forest, and the edge by which it was reached.
struct Reached {
  Vertex vertex = 0;
  std::optional<std::uint32_t> edge;  ///< None for the root of a tree.
};

/// The vertices of a spanning forest (Kruskal), breadth first. An edge is in the forest where edges of lower number do not
/// connect its vertices. Each of `roots` that is not yet reached from those before it is a root.
std::vector<Reached> spanning_forest(std::size_t vertices, const std::vector<Edge>& edges, const std::vector<Vertex>& roots);

/// The vertices of a largest set that are all adjacent to each other, ascending; of several such sets the first that is found.
/// For graphs of at most a hundred vertices or so: the time may grow exponentially (Bron and Kerbosch, 1973).
std::vector<Vertex> largest_clique(std::size_t vertices, const std::vector<Edge>& edges);

/// All vertices of a graph, path after path, and how many of its edges the paths take.
struct PathCover {
  std::vector<Vertex> order;
  std::size_t edges = 0;
};

/// Paths made of directed edges, taken one after the other where neither vertex has two already and no path closes: in the
/// order of `edges` or, where that leaves fewer paths, those with the fewest other edges at their vertices first. A path runs
/// as its edges point, its first edge where they disagree; paths follow each other as their starts are mentioned, vertices
/// without a path behind them. Edges along these paths, then the others, have the same cover. O(E log E).
PathCover cover_by_paths(std::size_t vertices, const std::vector<Edge>& edges);

}  // namespace mapjoin
