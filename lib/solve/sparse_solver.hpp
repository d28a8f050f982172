// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The interface of the engines: a sparse Cholesky factorisation of blocks whose pattern stays while its values change.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/engine.hpp>
#include <mapjoin/solve/supernodes.hpp>
#include <memory>
#include <vector>

namespace mapjoin {

/// A = L Lᵀ of a matrix that is already in its elimination order, as it stays.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;

  /// Symbolic analysis of the pattern, which stays until the next call.
  virtual void analyse(const BlockLower& matrix) = 0;

  /// Numeric factorisation. Returns scalar columns whose pivot is not positive or has lost all its digits to cancellation (see
  /// has_lost_digits()), where the matrix is singular to working precision: ascending, the first one always among them; empty
  /// if the matrix is regular.
  virtual std::vector<std::int64_t> factorise(const BlockLower& matrix) = 0;

  /// A⁻¹ B by the last factorisation, which must have succeeded.
  virtual Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const = 0;
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }

  /// L of that factorisation; it holds until the next one.
  virtual Supernodes supernodes() const = 0;
  /// Supernodes of L, and memory of its values (bytes), known after analyse().
  virtual std::size_t supernode_count() const = 0;
  virtual std::int64_t bytes() const = 0;
};

std::unique_ptr<SparseSolver> make_solver(Engine engine);

}  // namespace mapjoin
