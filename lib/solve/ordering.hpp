// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Variables, their elimination orders, partitions and elimination trees (SuiteSparse, METIS).

#include <cstdint>
#include <mapjoin/model/index.hpp>
#include <vector>

namespace mapjoin {

struct BlockLower;

/// A block of unknowns (a pose, a feature) by the number that the problem gives it.
using Variable = StrongIndex<struct VariableTag>;
/// A block column of a matrix in elimination order: the position of its variable in that order.
using Column = StrongIndex<struct ColumnTag>;

/// A variable with a constant value: it has no columns.
inline constexpr Variable kConstant = -1;

/// The neighbours of each variable, without itself, in an undirected graph.
using BlockGraph = Lists<Variable, Variable>;

/// Constraints on an elimination order.
struct Ordering {
  Table<Column, Variable> given = {};  ///< All variables in the order to take, or empty.
  /// Ranks of variables: each comes after all of lower rank that it is coupled to; empty: all are of one rank.
  Table<Variable, int> ranks = {};
  Table<Variable, int> weights = {};  ///< Weights of variables in nested dissection; empty: all the same.
  std::vector<Variable> border = {};  ///< Variables that are not eliminated; they come last, in this order.
};

/// A fill-reducing elimination order: nested dissection (METIS), which decides everything at scale, or approximate minimum
/// degree (AMD; CAMD with ranks) for graphs too small to dissect. With ranks, larger graphs are dissected without the variables
/// above the lowest rank, which follow by rank. A border is left out while the others are ordered. Orders are postordered, so
/// that each subtree is one run; only a given order with a border is taken as it is. The same graph gives the same order, from
/// any thread.
Table<Column, Variable> elimination_order(const BlockGraph& graph, const Ordering& ordering = {});

/// The column of each variable in an order.
Table<Variable, Column> inverse_order(const Table<Column, Variable>& order);

/// The part of each variable of an undirected graph, from 0: parts of equal weight but for a few per cent, with few edges
/// between them (METIS, by recursive bisection). The same graph gives the same parts, from any thread.
Table<Variable, std::int32_t> partition(const BlockGraph& graph, const Table<Variable, std::int32_t>& weights,
                                        std::int32_t parts);

/// The block columns of the Cholesky factor L of a matrix, eliminated in its own order (CHOLMOD's analysis).
struct EliminationTree {
  Table<Column, Column> parent;  ///< Row of the first block below the diagonal; the number of columns for a root.
  Table<Column, int> counts;     ///< Blocks of the column, the diagonal included.
};

/// The elimination tree of a matrix by its pattern; the matrix needs no values.
EliminationTree elimination_tree(const BlockLower& matrix);

}  // namespace mapjoin
