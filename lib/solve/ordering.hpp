// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Fill-reducing elimination orders of block variables.

#include <cstdint>
#include <mapjoin/model/ids.hpp>
#include <vector>

namespace mapjoin {

/// An undirected graph in compressed rows: the neighbours of v are neighbours[begin[v] .. begin[v+1]), without v itself.
struct BlockGraph {
  std::vector<std::int64_t> begin;
  std::vector<Index> neighbours;

  Index size() const { return static_cast<Index>(begin.size()) - 1; }
};

/// Variables by their place in the elimination: nested dissection (METIS), which decides everything at scale; approximate
/// minimum degree for graphs too small to dissect; either postordered. The same graph gives the same order, from any thread.
std::vector<Index> elimination_order(const BlockGraph& graph);

/// An order that is given, postordered: the same elimination with every subtree in one run.
std::vector<Index> postordered(const BlockGraph& graph, const std::vector<Index>& order);

/// The place of each variable in an order.
std::vector<Index> inverse_order(const std::vector<Index>& order);

}  // namespace mapjoin
