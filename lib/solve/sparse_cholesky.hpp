// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Cholesky factorisation of a sparse symmetric matrix whose pattern stays while its values change.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/supernodes.hpp>
#include <memory>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

/// The lower triangle of a symmetric matrix in compressed columns, rows ascending. Entries above the diagonal are ignored.
struct SparseLower {
  std::vector<std::int64_t> column_begin;  ///< n + 1 offsets.
  std::vector<std::int64_t> rows;
  std::vector<double> values;

  std::int64_t size() const { return static_cast<std::int64_t>(column_begin.size()) - 1; }
};

/// L Lᵀ of a matrix that is already in its elimination order, as it stays. Works on one thread.
class SparseCholesky {
 public:
  SparseCholesky();
  ~SparseCholesky();
  SparseCholesky(SparseCholesky&&) noexcept;
  SparseCholesky& operator=(SparseCholesky&&) noexcept;

  /// Symbolic analysis; `matrix` keeps its pattern until the next call. Throws std::bad_alloc when memory runs out.
  void analyse(const SparseLower& matrix);

  /// Numeric factorisation. Returns the first column whose pivot is not positive or has lost all its digits to cancellation
  /// (pivot² below 1e-14 of the diagonal), where the matrix is singular to working precision; nothing if it is regular.
  std::optional<std::int64_t> factorise(const SparseLower& matrix);

  /// A⁻¹ b by the last factorisation that succeeded.
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }
  /// A⁻¹ B, likewise.
  Eigen::MatrixXd solve_columns(const Eigen::MatrixXd& B) const;

  /// L of that factorisation; it holds until the next one.
  Supernodes supernodes() const;

 private:
  struct Factor;
  std::unique_ptr<Factor> factor_;
};

/// The name of the BLAS in use, on one thread, for the report.
std::string blas_name();

}  // namespace mapjoin
