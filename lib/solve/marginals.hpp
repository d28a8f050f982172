// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Covariances of block variables by the factor of their normal equations: blocks of H⁻¹.

#include <Eigen/Core>
#include <Eigen/SparseCore>
#include <mapjoin/solve/inverse_subset.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>

namespace mapjoin {

/// The blocks of H⁻¹ on the pattern of the factor: every variable, and every pair that one observation ties together.
class Marginals {
 public:
  /// By the last factorisation; `equations` must outlive the marginals. See InverseSubset for memory and `go_on`.
  explicit Marginals(const NormalEquations& equations, const InverseSubset::GoOn& go_on = nullptr)
      : equations_(&equations), subset_(equations.supernodes(), go_on) {}

  /// What the constructor asks for (bytes).
  static std::int64_t bytes(const NormalEquations& equations) { return InverseSubset::bytes(equations.supernodes()); }

  /// The joint covariance of variables of which every two are in the pattern (else std::out_of_range), in the order given.
  Eigen::MatrixXd joint(std::span<const Index> variables) const;
  Eigen::MatrixXd operator[](Index variable) const { return joint({&variable, 1}); }

 private:
  const NormalEquations* equations_;
  InverseSubset subset_;
};

/// J H⁻¹ Jᵀ, the covariance of any linear functions of the variables, by solves with the columns of Jᵀ (over the variables in
/// their own order, as a vector of `equations` is). A unit column per entry gives the joint covariance of any variables.
Eigen::MatrixXd covariance_of(const NormalEquations& equations, const Eigen::SparseMatrix<double>& J_transposed);

/// What covariance_of() asks for with `rows` rows of J (bytes).
std::int64_t covariance_bytes(const NormalEquations& equations, Eigen::Index rows);

}  // namespace mapjoin
