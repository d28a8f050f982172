// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Variables, the order in which they are eliminated, and what SuiteSparse and METIS say of that order.

#include <cstdint>
#include <mapjoin/model/index.hpp>
#include <vector>

namespace mapjoin {

struct BlockLower;

/// A block of unknowns (a pose, a feature) by the number that the problem gives it.
using Variable = StrongIndex<struct VariableTag>;
/// A block column of a matrix in elimination order: the variable that is eliminated so many others have been.
using Column = StrongIndex<struct ColumnTag>;

/// A variable with a constant value: it has no columns.
inline constexpr Variable kConstant = -1;

/// The neighbours of each variable, without itself, in an undirected graph.
using BlockGraph = Lists<Variable, Variable>;

/// What is known of an elimination order beforehand.
struct Ordering {
  Table<Column, Variable> given = {};  ///< All variables in the order to take, or none.
  /// A variable comes after all of lower rank that it is coupled to; empty: all are of one rank.
  Table<Variable, int> ranks = {};
  Table<Variable, int> weights = {};  ///< What a variable counts for where it is dissected; empty: all the same.
  std::vector<Variable> border = {};  ///< Variables that are not eliminated: they come last, in this order.
};

/// A fill-reducing order of elimination: nested dissection (METIS), which decides everything at scale; approximate minimum
/// degree (AMD) for graphs too small to dissect, of which there is a constrained one (CAMD) where there are ranks; larger ones
/// are dissected without what is not of the lowest rank. Every order, a given one too, is postordered: each subtree is one run.
/// The order of what a border leaves is found without it. The same graph gives the same order, from any thread.
Table<Column, Variable> elimination_order(const BlockGraph& graph, const Ordering& ordering = {});

/// The column of each variable in an order.
Table<Variable, Column> inverse_order(const Table<Column, Variable>& order);

/// Parts of an undirected graph, from 0 on, of as much weight as each other but for a few per cent, with few edges between them
/// (METIS, by recursive bisection). The same graph gives the same parts, from any thread.
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
