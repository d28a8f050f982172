// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// CHOLMOD's symbolic analysis of block patterns: elimination tree, postorder, column counts.

#include <mapjoin/model/ids.hpp>
#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <vector>

namespace mapjoin {

/// The block columns of the Cholesky factor L of a matrix, eliminated in its own order.
struct EliminationTree {
  std::vector<Index> parent;  ///< Row of the first block below the diagonal of each column; the number of columns for a root.
  std::vector<Index> counts;  ///< Blocks of each column, the diagonal included.
};

/// The elimination tree of a matrix by its pattern; the matrix needs no values.
EliminationTree elimination_tree(const BlockLower& matrix);

/// The same elimination with the places of every subtree in one run: equal fill, and its supernodes are runs of columns.
std::vector<Index> postordered(const BlockGraph& graph, const std::vector<Index>& order);

}  // namespace mapjoin
