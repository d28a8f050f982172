// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/solve/marginals.hpp>
#include <vector>

namespace mapjoin {
namespace {

/// Right-hand sides solved at once: dense products pay, and their memory stays small beside the factor's.
constexpr Eigen::Index kColumnsAtOnce = 64;

}  // namespace

Eigen::MatrixXd Marginals::joint(std::span<const Index> variables) const {
  std::vector<std::int64_t> columns;
  for (const Index v : variables) {
    for (int i = 0; i < equations_->dof(v); ++i) columns.push_back(equations_->column_of(v) + i);
  }
  return subset_.block(columns);
}

Eigen::MatrixXd covariance_of(const NormalEquations& equations, const Eigen::SparseMatrix<double>& J_transposed) {
  const Eigen::Index size = J_transposed.cols();
  Eigen::MatrixXd covariance(size, size);
  for (Eigen::Index first = 0; first < size; first += kColumnsAtOnce) {
    const Eigen::Index count = std::min(kColumnsAtOnce, size - first);
    const Eigen::MatrixXd solution = equations.solve_columns(J_transposed.middleCols(first, count));
    covariance.middleCols(first, count) = J_transposed.transpose() * solution;
  }
  return 0.5 * (covariance + covariance.transpose());
}

std::int64_t covariance_bytes(const NormalEquations& equations, Eigen::Index rows) {
  // The result and its transpose; a batch of right-hand sides, permuted, solved, copied and permuted back.
  return 8 * (2 * rows * rows + 6 * kColumnsAtOnce * equations.size());
}

}  // namespace mapjoin
