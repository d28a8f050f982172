// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where a log or a set of maps is one edge or one feature away from falling apart.

#include <cstddef>
#include <vector>

namespace mapjoin {

/// Edges in a row, each of which would part the graph: nothing confirms any of them.
struct LoneChain {
  std::size_t first = 0;  ///< Vertices (TieVertices): the first and
  std::size_t last = 0;   ///< the last by index.
  std::size_t edges = 0;
};

/// Only what parts something from something counts: on either side of a link there is a cycle. The ends of a way on which
/// nothing closes, and features seen once, are no weak links.
struct WeakLinks {
  std::vector<LoneChain> chains;      ///< Between poses (or the World).
  std::vector<std::size_t> features;  ///< Vertices, ascending, without which poses fall apart.
};

/// By the biconnected components of the graph. O(ties log ties).
template <typename LogOrSet>
WeakLinks weak_links(const LogOrSet& tied);

}  // namespace mapjoin
