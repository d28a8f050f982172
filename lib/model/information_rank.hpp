// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How many rows of an observation were measured.

#include <Eigen/Core>
#include <cstdint>

namespace mapjoin {

/// The rank of a positive semidefinite matrix, by pivoted Cholesky of W scaled to a unit diagonal: metres and radians weigh
/// alike.
template <int Rows>
std::int64_t information_rank(const Eigen::Matrix<double, Rows, Rows>& W);

}  // namespace mapjoin
