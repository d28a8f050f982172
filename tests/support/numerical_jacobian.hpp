// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Jacobians by central differences, to check analytic ones against.

#include <Eigen/Core>

namespace mapjoin::testing {

/// The Jacobian ∂f/∂δ at δ = 0 of `f`, a function from column vectors of `cols` entries to column vectors, by central
/// differences with step `h`.
template <typename F>
Eigen::MatrixXd numerical_jacobian(F&& f, Eigen::Index cols, double h = 1e-6) {
  const Eigen::VectorXd zero = Eigen::VectorXd::Zero(cols);
  Eigen::MatrixXd J;
  for (Eigen::Index c = 0; c < cols; ++c) {
    Eigen::VectorXd plus = zero;
    Eigen::VectorXd minus = zero;
    plus[c] += h;
    minus[c] -= h;
    const Eigen::VectorXd column = (Eigen::VectorXd(f(plus)) - Eigen::VectorXd(f(minus))) / (2.0 * h);
    if (J.size() == 0) J.resize(column.size(), cols);
    J.col(c) = column;
  }
  return J;
}

}  // namespace mapjoin::testing
