// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Symbolic factorisation: the supernodes of a Cholesky factor, the tree in which they depend on each other, and the layout.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <mapjoin/solve/block_lower.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// A range [begin, end) of a list.
struct Slice {
  std::size_t begin = 0;
  std::size_t end = 0;

  std::size_t size() const { return end - begin; }
  template <typename T>
  std::span<const T> of(const std::vector<T>& list) const {
    return {list.data() + begin, size()};
  }
};

/// Block columns of L with the same rows below them, kept as one dense panel of height × width. Its front is its own rows,
/// then those below.
struct FactorNode {
  IndexRange<Column> columns;
  std::size_t parent = 0;        ///< The supernode of the first row below; the number of supernodes for a root.
  Slice children;                ///< Its children, in SupernodalTree::children, ascending.
  Slice rows;                    ///< Its block rows below, in SupernodalTree::rows, ascending.
  Slice runs;                    ///< Places of its rows below in its parent's front, in SupernodalTree::runs.
  std::int64_t first_value = 0;  ///< Its panel in the values of L.
  Eigen::Index width = 0;        ///< Scalar columns; 0 for a given front.
  Eigen::Index height = 0;       ///< Scalar rows of the front.
  std::size_t given = 0;         ///< Number of a given front.

  Eigen::Index below() const { return height - width; }
};

/// Scalar rows [from, from + length) below a supernode are rows [to, to + length) of its parent's front.
struct RowRun {
  std::int32_t from = 0;
  std::int32_t to = 0;
  std::int32_t length = 0;
};

/// Supernodes that are worked on one after the other, ascending, once the tasks that they depend on are done.
struct FactorTask {
  std::vector<std::size_t> nodes;
  std::vector<FactorTask> before;  ///< Tasks that these depend on, independent of each other.
};

struct SupernodalTree {
  std::vector<FactorNode> nodes;  ///< In the order of their columns.
  std::vector<std::size_t> children;
  std::vector<Column> rows;
  std::vector<RowRun> runs;
  std::vector<std::int32_t> front_rows;  ///< First scalar row in the front, for each entry of BlockLower::rows.
  std::int64_t value_count = 0;          ///< Number of values of L.
  FactorTask tasks;                      ///< Shares of the work, the same for any number of threads.
  Column border = 0;                     ///< First column that is not eliminated; the border, if any, is the last node.

  bool is_border(const FactorNode& node) const { return node.width > 0 && node.columns.first >= border; }

  std::span<const std::size_t> children_of(const FactorNode& node) const { return node.children.of(children); }
  std::span<const Column> rows_of(const FactorNode& node) const { return node.rows.of(rows); }
  std::span<const RowRun> runs_of(const FactorNode& node) const { return node.runs.of(runs); }
};

/// The supernodal tree of a matrix in its elimination order, by its pattern (Liu, Ng & Peyton, 1993). `given` are the block
/// rows, ascending, of fronts that were eliminated before: any two of them are coupled in the matrix. The last `border` columns
/// are not eliminated.
SupernodalTree supernodal_tree(const BlockLower& matrix, std::span<const std::span<const Column>> given = {},
                               std::size_t border = 0);

/// Cuts the tree into tasks where independent subtrees are worth one. Depends on the tree alone.
FactorTask factor_tasks(const SupernodalTree& tree);

/// Calls f(supernode) for each after all its children; in parallel if tasks are independent.
void for_each_upwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f);
/// Calls f(supernode) for each after its parent.
void for_each_downwards(const FactorTask& tasks, const std::function<void(std::size_t)>& f);

}  // namespace mapjoin
