// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Weak links: single edges or features that alone keep a log or a set of maps connected.

#include <cstddef>
#include <vector>

namespace mapjoin {

/// A chain of bridges, edges in a row, each of which alone connects the graph: nothing confirms any of them.
struct LoneChain {
  std::size_t first = 0;  ///< The first vertex (TieVertices) by index.
  std::size_t last = 0;   ///< The last vertex by index.
  std::size_t edges = 0;
};

/// Bridges and cut vertices with a cycle on either side. The ends of a trajectory without closures, and features seen once, are
/// no weak links.
struct WeakLinks {
  std::vector<LoneChain> chains;      ///< Between poses (or the World).
  std::vector<std::size_t> features;  ///< Feature vertices, ascending, without which poses fall apart.
};

/// Finds weak links by the biconnected components of the graph. O(ties log ties).
template <typename LogOrSet>
WeakLinks weak_links(const LogOrSet& tied);

}  // namespace mapjoin
