// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A small system all of whose entries come in given fronts, none in the matrix itself.

#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <tests/support/random.hpp>
#include <vector>

namespace mapjoin::testing {

/// Three blocks, every two of which are coupled by a given front, which is made when it is needed.
struct CoupledByFronts {
  explicit CoupledByFronts(Random& random) {
    for (const Eigen::Index size : {4, 3, 2}) pattern.offsets.push_back(pattern.offsets.back() + size);
    for (const std::vector<Column>& rows : {std::vector<Column>{0, 1, 2}, {1, 2}, {2}}) pattern.rows.push_back(rows);
    for (const std::vector<Column>& rows : {std::vector<Column>{0, 1}, {0, 2}, {1, 2}}) {
      std::vector<Eigen::Index> scalars;
      for (const Column row : rows) {
        for (auto i = pattern.offsets[row]; i < pattern.offsets[row + 1]; ++i) scalars.push_back(i);
      }
      Eigen::MatrixXd M(std::ssize(scalars), std::ssize(scalars));
      for (auto& entry : M.reshaped()) entry = random.uniform(-1.0, 1.0);
      const Eigen::MatrixXd summand = M * M.transpose() + Eigen::MatrixXd::Identity(M.rows(), M.cols());
      A(scalars, scalars) += summand;
      const auto make = [summand](DenseBlock update) { update.triangularView<Eigen::Lower>() = summand; };
      fronts.push_back({rows, {nullptr, 0, 0, Eigen::OuterStride<>(0)}, make});
    }
  }
  BlockLower pattern;
  std::vector<GivenFront> fronts;
  Eigen::MatrixXd A = Eigen::MatrixXd::Zero(9, 9);  ///< The sum of the fronts.
};

}  // namespace mapjoin::testing
