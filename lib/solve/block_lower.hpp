// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A sparse symmetric matrix of small dense blocks, by the lower triangle.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/ordering.hpp>
#include <vector>

namespace mapjoin {

/// Block column k is one dense panel, stored column by column: the block rows that `rows` names, one below the other, with as
/// many columns as block k has rows. Entries above the diagonal in diagonal blocks are ignored.
struct BlockLower {
  Table<Column, Eigen::Index> offsets = {0};      ///< The first scalar row of each block, and the total.
  Lists<Column, Column> rows;                     ///< Block rows of each block column, ascending, the diagonal first.
  Table<Column, Eigen::Index> heights;            ///< Scalar rows of each panel.
  Table<Column, std::int64_t> first_value = {0};  ///< Begin of each panel in `values`, and the total.
  std::vector<double> values;                     ///< Empty if the matrix is a pattern alone.

  IndexRange<Column> columns() const { return {0, Column(rows.size())}; }
  Eigen::Index size() const { return offsets.back(); }
  /// Scalar rows of block k.
  Eigen::Index dof(Column k) const { return offsets[k + 1] - offsets[k]; }
  Eigen::Map<Eigen::MatrixXd> panel(Column k) { return {values.data() + first_value[k], heights[k], dof(k)}; }
  Eigen::Map<const Eigen::MatrixXd> panel(Column k) const { return {values.data() + first_value[k], heights[k], dof(k)}; }

  /// Makes panels of zeros for the block columns whose sizes and rows are known.
  void lay_out();
  Eigen::VectorXd diagonal() const;
  void set_diagonal(const Eigen::VectorXd& diagonal);
  /// The symmetric matrix, both triangles, times v.
  Eigen::VectorXd operator*(const Eigen::VectorXd& v) const;
  /// The matrix over the blocks that are kept.
  BlockLower principal_submatrix(const Table<Column, bool>& is_kept) const;
};

}  // namespace mapjoin
