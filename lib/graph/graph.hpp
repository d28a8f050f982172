// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Undirected graphs for Boost.Graph: components, bridges, spanning forests, cliques and covers by paths.

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

/// True for each edge that is a bridge: without it its two vertices are not connected. O(vertices + edges).
std::vector<bool> bridges_of(std::size_t vertices, const std::vector<Edge>& edges);

/// A vertex of a forest, and the edge by which it was reached.
struct Reached {
  Vertex vertex = 0;
  std::optional<std::uint32_t> edge;  ///< nullopt for the root of a tree.
};

/// The vertices of a spanning forest (Kruskal), breadth first. An edge is in the forest if edges of lower number do not connect
/// its vertices. Each of `roots` that is not reached from those before it is a root.
std::vector<Reached> spanning_forest(std::size_t vertices, const std::vector<Edge>& edges, const std::vector<Vertex>& roots);

/// The vertices of a largest clique of the graph of `edges`, ascending; of several the first that is found. For graphs of at
/// most a hundred vertices or so: the time may grow exponentially (Bron and Kerbosch, 1973).
std::vector<Vertex> largest_clique(const std::vector<Edge>& edges);

/// All vertices of a graph, path after path, and the number of its edges on the paths.
struct PathCover {
  std::vector<Vertex> order;
  std::size_t edges = 0;
};

/// A greedy cover by paths of directed edges. Edges are taken one after the other if neither vertex has two already and no
/// cycle closes: in the order of `edges` or, if that leaves fewer paths, those with the fewest other edges at their vertices
/// first. A path starts at the end that its edge leads away from; if both or neither do, at the one that edges mention first.
/// Paths follow each other as their starts are mentioned, those without an end that an edge leads away from last, then vertices
/// without a path. Edges along these paths, then the others, have the same cover. O(E log E).
PathCover cover_by_paths(std::size_t vertices, const std::vector<Edge>& edges);

}  // namespace mapjoin
