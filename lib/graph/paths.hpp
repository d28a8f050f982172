// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Paths that cover a graph: the way that was driven, where nothing but the edges tells it.

#include <cstddef>
#include <mapjoin/graph/graph.hpp>
#include <vector>

namespace mapjoin {

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
