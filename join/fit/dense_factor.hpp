// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A linearised factor of a joining system as dense matrices.

#include <Eigen/Core>
#include <mapjoin/join/joining_system.hpp>

namespace mapjoin {

/// A linearised factor of any kind: its residual r, information W and Jacobian J, with the columns of the base, then those of
/// the targets.
struct DenseFactor {
  Eigen::VectorXd r;
  Eigen::MatrixXd W;
  Eigen::MatrixXd J;
};

/// A factor of `system`, linearised at its estimate.
template <int Dim>
DenseFactor dense_factor(const JoiningSystem<Dim>& system, std::size_t factor);

/// Calls f(v, column) for the variables of a factor, with their first column in its J; skips constant ones, all poses.
template <int Dim, typename F>
void for_each_variable(const NormalEquations& equations, std::size_t factor, F&& f) {
  Eigen::Index column = 0;
  for (const Variable v : equations.pattern().factors[factor]) {
    if (v != kConstant) f(v, column);
    column += v == kConstant ? kPoseDof<Dim> : equations.dof(v);
  }
}

/// J X of a factor, where X has the rows of all variables.
template <int Dim>
Eigen::MatrixXd times(const Eigen::MatrixXd& J, const Eigen::Ref<const Eigen::MatrixXd>& X, std::size_t factor,
                      const NormalEquations& equations);

}  // namespace mapjoin
