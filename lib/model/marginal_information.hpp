// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What some rows of an observation say whatever the others are.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <vector>

namespace mapjoin {

/// The information of the rows L with the others, N, left free: W_LL - W_LN W_NN⁻¹ W_NL. With it rᵀWr is what L says alone,
/// and, of the rest, what is never negative: N given L.
inline Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& W, const std::vector<Eigen::Index>& L,
                                            const std::vector<Eigen::Index>& N) {
  Eigen::MatrixXd W_LL = W(L, L);
  if (N.empty() || L.empty()) return W_LL;
  const Eigen::MatrixXd W_NL = W(N, L);
  W_LL -= W_NL.transpose() * Eigen::MatrixXd(W(N, N)).ldlt().solve(W_NL);
  return 0.5 * (W_LL + W_LL.transpose());
}

}  // namespace mapjoin
