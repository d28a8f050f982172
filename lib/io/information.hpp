// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The check that every information matrix passes at the door, and the repair of indefinite ones.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/geometry/rotation.hpp>
#include <optional>
#include <string>

namespace mapjoin {

/// The information matrix of a covariance, exactly symmetric; nothing where the covariance is not finite and positive definite.
template <int Size>
std::optional<Matrix<Size>> information_of_covariance(const Matrix<Size>& covariance);

/// What is wrong with a matrix that should be symmetric, "is not finite" or "is not symmetric …"; nothing where it will do.
/// Asymmetry up to 1e-9 of the largest entry is averaged away.
template <int Size>
std::optional<std::string> make_symmetric(Matrix<Size>& M);

/// The check of the information matrices of one file. Sizes 2, 3, 6 and Eigen::Dynamic.
class InformationCheck {
 public:
  /// With `repair`, an indefinite matrix is replaced by its nearest semidefinite one (in Frobenius norm: eigenvalues clipped at
  /// zero) and counted.
  explicit InformationCheck(bool repair) : repair_(repair) {}

  /// What is wrong with `W`, to follow "the information matrix of edge 3-4": as make_symmetric(), or "is indefinite …"; nothing
  /// where it will do. Eigenvalues down to -1e-9 of the largest count as round-off and are left alone. A Cholesky factorisation
  /// decides most; O(Size³).
  template <int Size>
  std::optional<std::string> fault(Matrix<Size>& W);

  std::int64_t repaired() const { return repaired_; }

 private:
  bool repair_;
  std::int64_t repaired_ = 0;
};

}  // namespace mapjoin
