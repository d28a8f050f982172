// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Information matrices: the check that each of them, and each covariance, passes at the door, its repair, its rank, and what
// some of its rows say alone.

#include <cstdint>
#include <mapjoin/geometry/rotation.hpp>
#include <mapjoin/model/conventions.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

/// The information matrix of a covariance, exactly symmetric; nothing where the covariance is not finite and positive definite.
template <int Size>
std::optional<Matrix<Size>> information_of_covariance(const Matrix<Size>& covariance);

/// The check of the information matrices and covariances of one input. Sizes 2, 3, 6 and Eigen::Dynamic. Both must be finite
/// and symmetric: asymmetry up to 1e-6 of the largest entry, as filters leave it, is averaged away, and counted above 1e-9.
/// What is wrong is a phrase to follow "the information matrix of edge 3-4".
class InformationCheck {
 public:
  /// For matrices in memory: nothing is repaired.
  InformationCheck() = default;
  /// For a reader: with `repair`, a matrix that is asymmetric or indefinite is repaired and counted; without, the fault names
  /// the option.
  explicit InformationCheck(bool repair) : repair_(repair), offer_(!repair) {}

  /// The fault of an information matrix, "is not finite", "is not symmetric …" or "is indefinite …"; nothing where it will do.
  /// Eigenvalues down to -1e-9 of the largest count as round-off and are left alone. Repaired, W is the nearest semidefinite
  /// matrix (in Frobenius norm: eigenvalues clipped at zero). A Cholesky factorisation decides most; O(Size³).
  template <int Size>
  std::optional<std::string> fault(Matrix<Size>& W);

  /// Turns a covariance into its information matrix, or gives its fault, "is not positive definite" among them. Repaired, the
  /// eigenvalues of its correlations are lifted to 1e-9 of the largest; the variances must be positive.
  template <int Size>
  std::optional<std::string> invert(Matrix<Size>& covariance);

  /// What was done to the matrices so far.
  const MatrixRepairs& repairs() const { return repairs_; }

 private:
  template <int Size>
  std::optional<std::string> make_symmetric(Matrix<Size>& M);
  std::string refusal(std::string fault, const char* remedy) const;

  bool repair_ = false;
  bool offer_ = false;  ///< The fault names the option.
  MatrixRepairs repairs_;
};

/// The rank of a positive semidefinite matrix, by pivoted Cholesky of W scaled to a unit diagonal: metres and radians weigh
/// alike.
template <int Rows>
std::int64_t information_rank(const Matrix<Rows>& W);

/// The information of the rows L with the others, N, left free: W_LL - W_LN W_NN⁻¹ W_NL. With it rᵀWr is what L says alone,
/// and, of the rest, what is never negative: N given L.
Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& W, const std::vector<Eigen::Index>& L,
                                     const std::vector<Eigen::Index>& N);

}  // namespace mapjoin
