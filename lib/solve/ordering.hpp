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

/// What is known of the order beforehand.
struct Ordering {
  std::vector<Index> given;  ///< All variables in the order to take, or none.
  Index last_count = 0;      ///< So many last variables are eliminated after those that they are coupled to.
};

/// Variables by their place in the elimination: nested dissection (METIS), which decides everything at scale; approximate
/// minimum degree (AMD) for graphs too small to dissect; the constrained one (CAMD) where some variables are to be the last.
/// All are postordered, a given order, too: every subtree is one run. The same graph gives the same order, from any thread.
std::vector<Index> elimination_order(const BlockGraph& graph, const Ordering& ordering = {});

/// The place of each variable in an order.
std::vector<Index> inverse_order(const std::vector<Index>& order);

}  // namespace mapjoin
