// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A sparse symmetric matrix of small dense blocks, by the lower triangle.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/model/ids.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// Block column k is one dense panel, column by column: as many columns as block k has rows, and one below the other the block
/// rows that `rows` names. What the diagonal blocks hold above their diagonal is ignored.
struct BlockLower {
  std::vector<Eigen::Index> offsets = {0};      ///< The first scalar row of each block, and the total.
  std::vector<std::int64_t> begin = {0};        ///< Per block column into `rows`, and the total.
  std::vector<Index> rows;                      ///< Of each block column ascending, the diagonal first.
  std::vector<Eigen::Index> heights;            ///< Scalar rows of each panel.
  std::vector<std::int64_t> first_value = {0};  ///< Per panel into `values`, and the total.
  std::vector<double> values;

  std::size_t blocks() const { return offsets.size() - 1; }
  Eigen::Index size() const { return offsets.back(); }
  /// Scalar rows of block k.
  Eigen::Index dof(std::size_t k) const { return offsets[k + 1] - offsets[k]; }
  std::span<const Index> rows_of(std::size_t k) const {
    return {rows.data() + begin[k], static_cast<std::size_t>(begin[k + 1] - begin[k])};
  }
  /// The i-th diagonal entry of block k.
  double& diagonal(std::size_t k, Eigen::Index i) { return values[static_cast<std::size_t>(diagonal_place(k, i))]; }
  double diagonal(std::size_t k, Eigen::Index i) const { return values[static_cast<std::size_t>(diagonal_place(k, i))]; }

  /// Names the block rows of the next block column, ascending from its own on.
  void append_column(std::span<const Index> column) {
    rows.insert(rows.end(), column.begin(), column.end());
    begin.push_back(static_cast<std::int64_t>(rows.size()));
  }
  /// Panels of zeros for the block columns whose sizes and rows have been named.
  void lay_out() {
    for (std::size_t k = 0; k < blocks(); ++k) {
      Eigen::Index height = 0;
      for (const Index row : rows_of(k)) height += dof(static_cast<std::size_t>(row));
      heights.push_back(height);
      first_value.push_back(first_value.back() + height * dof(k));
    }
    values.assign(static_cast<std::size_t>(first_value.back()), 0.0);
  }

 private:
  std::int64_t diagonal_place(std::size_t k, Eigen::Index i) const { return first_value[k] + i * (heights[k] + 1); }
};

}  // namespace mapjoin
