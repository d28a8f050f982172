// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Covariances between any few variables: blocks of H⁻¹ by substitution with its Cholesky factor.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// The blocks of H⁻¹ between any two variables. With H = L Lᵀ, the columns of H⁻¹ of some of them are
///
///   H⁻¹ E = L⁻ᵀ Y,    Y = L⁻¹ E,
///
/// E being their unit columns. Y is zero but in the supernodes on the paths from theirs to the root of the elimination tree,
/// and the rows of L⁻ᵀ Y of other variables follow from those on the paths of these. No variable may be constant; any may be
/// asked for more than once. Any threads may ask at once.
class CrossCovariances {
 public:
  /// By the last factorisation of `equations`, which must stay.
  explicit CrossCovariances(const NormalEquations& equations) : equations_(equations) {}

  /// A row for each entry of the rows' variables, a column for each of the columns'. For each row the work is that of the paths
  /// of both.
  Eigen::MatrixXd between(std::span<const Variable> rows, std::span<const Variable> columns) const;
  /// The joint covariance of variables, in the order given.
  Eigen::MatrixXd joint(std::span<const Variable> variables) const;
  /// What their joint covariance asks for (bytes), but for a little at each supernode.
  std::int64_t bytes(std::span<const Variable> variables) const;

 private:
  /// A few rows of a matrix with the columns of L; only the columns of some supernodes and all their ancestors, ascending, side
  /// by side.
  struct RowsOnPaths {
    Supernodes nodes;
    std::vector<Eigen::Index> first;  // of `values`: the column that each node begins with, and their number
    Eigen::MatrixXd values;
  };
  /// The supernodes of some variables and all their ancestors, ascending.
  Supernodes on_paths(std::span<const Variable> variables) const;
  RowsOnPaths zeros_on_paths(std::span<const Variable> variables, Eigen::Index rows) const;
  Eigen::Index size_of(std::span<const Variable> variables) const;
  Eigen::Index column_in(const RowsOnPaths& rows, Variable v) const;
  std::vector<Eigen::Index> columns_below(const RowsOnPaths& rows, std::size_t k) const;
  /// Yᵀ of some variables.
  RowsOnPaths substitute_forward(std::span<const Variable> variables) const;
  /// (L⁻ᵀ Y)ᵀ on the paths of some variables.
  RowsOnPaths substitute_back(const RowsOnPaths& Y_transposed, std::span<const Variable> variables) const;

  const NormalEquations& equations_;
};

}  // namespace mapjoin
