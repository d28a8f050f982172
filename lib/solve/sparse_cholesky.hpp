// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Cholesky factorisation of a sparse symmetric matrix of blocks whose pattern stays while its values change.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/supernodal_tree.hpp>
#include <mapjoin/solve/supernodes.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace mapjoin {

/// L Lᵀ of a matrix that is already in its elimination order, as it stays: multifrontal (Duff & Reid, 1983), subtrees side by
/// side. The same to the last bit for any number of threads.
class SparseCholesky {
 public:
  /// Symbolic analysis of the pattern, which stays until the next call.
  void analyse(const BlockLower& matrix);

  /// Numeric factorisation. Returns the first scalar column whose pivot is not positive or has lost all its digits to
  /// cancellation (pivot² below 1e-14 of the diagonal), where the matrix is singular to working precision; nothing if it is
  /// regular.
  std::optional<std::int64_t> factorise(const BlockLower& matrix);

  /// A⁻¹ b by the last factorisation, which must have succeeded.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }
  /// A⁻¹ B, likewise.
  Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const;

  /// L of that factorisation; it holds until the next one.
  Supernodes supernodes() const;
  std::size_t supernode_count() const { return tree_.nodes.size(); }
  /// Memory of its values, known after analyse().
  std::int64_t bytes() const { return static_cast<std::int64_t>(sizeof(double)) * tree_.value_count; }

 private:
  SupernodalTree tree_;
  std::vector<Eigen::Index> offsets_;  ///< The first scalar row of each block, and the total.
  std::unique_ptr<double[]> values_;   ///< The panels of L.
};

}  // namespace mapjoin
