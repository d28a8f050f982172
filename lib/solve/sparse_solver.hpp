// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The interface of the engines: a sparse Cholesky factorisation of blocks whose pattern stays while its values change.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <mapjoin/solve/block_lower.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <memory>
#include <vector>

namespace mapjoin {

/// True if the pivot L_jj has lost all its digits to cancellation, or never had any: L_jj² is below 1e-14 of the diagonal entry
/// A_jj of the matrix, which is then singular to working precision.
inline bool has_lost_digits(double pivot, double diagonal) {
  return !(pivot * pivot > 1e-14 * std::abs(diagonal));
}

/// Columns [begin, end) of a Cholesky factor L as one dense block.
struct Supernode {
  std::int64_t begin = 0;
  std::int64_t end = 0;
  std::vector<std::int64_t> rows;  ///< Ascending: its own columns, then the rows below them.
  const double* values = nullptr;  ///< rows.size() × width(), column by column. Entries above the diagonal are ignored.

  std::int64_t width() const { return end - begin; }
};

/// A view of L, A = L Lᵀ, in the order of its columns; valid until A is factorised again.
using Supernodes = std::vector<Supernode>;

/// The factorisation A = L Lᵀ of a matrix given in its elimination order, which is kept.
class SparseSolver {
 public:
  virtual ~SparseSolver() = default;

  /// Symbolic analysis of the pattern, which is kept until the next call.
  virtual void analyse(const BlockLower& matrix) = 0;

  /// Numeric factorisation. Returns the scalar columns at which the matrix is singular to working precision (pivot not
  /// positive, or has_lost_digits()), ascending, the first one always among them; empty if the matrix is regular.
  virtual std::vector<std::int64_t> factorise(const BlockLower& matrix) = 0;

  /// A⁻¹ B by the last factorisation, which must have succeeded.
  virtual Eigen::MatrixXd solve_columns(Eigen::MatrixXd B) const = 0;
  Eigen::VectorXd solve(const Eigen::VectorXd& b) const { return solve_columns(b); }

  /// The supernode of L that has a column; valid until the next factorisation.
  virtual Supernode supernode_of(std::int64_t column) const = 0;
  /// All supernodes of L; valid until the next factorisation.
  Supernodes supernodes() const;
  /// The number of supernodes of L, and the memory of its values (bytes); known after analyse().
  virtual std::size_t supernode_count() const = 0;
  virtual std::int64_t bytes() const = 0;
};

inline Supernodes SparseSolver::supernodes() const {
  Supernodes factor(supernode_count());
  std::int64_t column = 0;
  for (Supernode& node : factor) {
    node = supernode_of(column);
    column = node.end;
  }
  return factor;
}

std::unique_ptr<SparseSolver> make_solver(Engine engine);

}  // namespace mapjoin
