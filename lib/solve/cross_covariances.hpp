// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Covariances between any two variables: blocks of H⁻¹, also off the pattern of its Cholesky factor.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/solve/normal_equations.hpp>
#include <vector>

namespace mapjoin {

/// The blocks of H⁻¹ between any two variables. From H⁻¹ = L⁻ᵀ L⁻¹ follows
///
///   P_uv = Y_uᵀ Y_v,    Y_u = L⁻¹ E_u,
///
/// E_u being the unit columns of u. Y_u is zero but in the supernodes on the path from that of u to the root of the elimination
/// tree, and two paths have their upper end in common, or nothing: the block is then zero.
class CrossCovariances {
 public:
  /// By the last factorisation of `equations`, which must stay.
  explicit CrossCovariances(const NormalEquations& equations);

  /// A row for each entry of u, a column for each of v; both must have a variable's columns. Any threads may ask at once.
  Eigen::MatrixXd between(Variable u, Variable v) const;

 private:
  /// Y_u by the supernodes on its path, ascending, one below the other.
  struct Path {
    std::vector<std::size_t> nodes;
    Eigen::MatrixXd Y;
  };
  std::size_t node_of(std::int64_t column) const { return node_of_[static_cast<std::size_t>(column)]; }
  std::vector<std::size_t> nodes_above(std::int64_t column) const;
  Path path(Variable u) const;

  const NormalEquations& equations_;
  Supernodes factor_;
  std::vector<std::size_t> node_of_;  // per column
};

}  // namespace mapjoin
