// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How many rows of an observation were measured.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <cstdint>

namespace mapjoin {

/// The rank of a positive semidefinite matrix, by pivoted Cholesky of W scaled to a unit diagonal: metres and radians weigh
/// alike.
template <int Rows>
std::int64_t information_rank(const Eigen::Matrix<double, Rows, Rows>& W) {
  constexpr double kZero = 1e-9;
  const Eigen::Matrix<double, Rows, 1> diagonal = W.diagonal();
  const Eigen::Matrix<double, Rows, 1> scale = (diagonal.array() > 0.0).select(diagonal.array().rsqrt(), 0.0);
  const Eigen::LDLT<Eigen::Matrix<double, Rows, Rows>> ldlt(scale.asDiagonal() * W * scale.asDiagonal());
  return (ldlt.vectorD().array() > kZero).count();
}

}  // namespace mapjoin
