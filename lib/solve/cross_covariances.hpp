// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Covariances between any few variables: blocks of H⁻¹ by substitution with its Cholesky factor.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// The blocks of H⁻¹ between any two variables. With H = L Lᵀ and E the unit columns of some variables, the columns of H⁻¹ of
/// these are
///
///   H⁻¹ E = L⁻ᵀ Y,    Y = L⁻¹ E.
///
/// Y is zero except in the supernodes on the paths from those of the variables to the root of the elimination tree, and the
/// rows of L⁻ᵀ Y of other variables follow from the rows on the paths of these. No variable may be constant; any may be asked
/// for more than once. Any threads may ask at once.
class CrossCovariances {
 public:
  /// Uses the last factorisation of `equations`, which must stay.
  explicit CrossCovariances(const NormalEquations& equations) : equations_(equations) {}

  /// The covariance between two lists of variables, by rows and columns in their order. The work for each row is that of the
  /// paths of both lists.
  Eigen::MatrixXd between(std::span<const Variable> rows, std::span<const Variable> columns) const;
  /// The joint covariance of variables, in the order given.
  Eigen::MatrixXd joint(std::span<const Variable> variables) const;
  /// Rows of H⁻¹ b for some variables, in their order; b has the rows `of_these` for them, and is zero for all others. The work
  /// is that of their paths, and nothing cancels as it does in products with large covariances.
  Eigen::MatrixXd solved(std::span<const Variable> variables, const Eigen::MatrixXd& of_these) const;
  /// The memory that joint() of these variables needs (bytes), except for a little at each supernode.
  std::int64_t bytes(std::span<const Variable> variables) const;

 private:
  /// Rows of a matrix with the columns of L, kept only in the columns of some supernodes and all their ancestors, ascending,
  /// side by side.
  struct RowsOnPaths {
    Supernodes nodes;
    std::vector<Eigen::Index> first;  // the column of `values` that each node begins with, then their number
    Eigen::MatrixXd values;
  };
  /// The supernodes of some variables and all their ancestors, ascending.
  Supernodes on_paths(std::span<const Variable> variables) const;
  RowsOnPaths zeros_on_paths(std::span<const Variable> variables, Eigen::Index rows) const;
  Eigen::Index size_of(std::span<const Variable> variables) const;
  Eigen::Index column_in(const RowsOnPaths& rows, Variable v) const;
  Eigen::MatrixXd columns_of(std::span<const Variable> variables, const RowsOnPaths& rows) const;
  std::vector<Eigen::Index> columns_below(const RowsOnPaths& rows, std::size_t k) const;
  /// (L⁻¹ B)ᵀ on the paths of some variables, which have these rows of B, all others none.
  RowsOnPaths substitute_forward(std::span<const Variable> variables, const Eigen::MatrixXd& of_these) const;
  /// (L⁻ᵀ Y)ᵀ on the paths of some variables.
  RowsOnPaths substitute_back(const RowsOnPaths& Y_transposed, std::span<const Variable> variables) const;

  const NormalEquations& equations_;
};

}  // namespace mapjoin
