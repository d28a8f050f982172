// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Information matrices: the check and repair of each of them, and of covariances, on input; their rank, range and marginals.

#include <cstdint>
#include <mapjoin/geometry/rotation.hpp>
#include <mapjoin/model/conventions.hpp>
#include <optional>
#include <string>
#include <vector>

namespace mapjoin {

/// The information matrix of a covariance, exactly symmetric; nullopt unless the covariance is finite and positive definite.
template <int Size>
std::optional<Matrix<Size>> information_of_covariance(const Matrix<Size>& covariance);

/// The check of the information matrices and covariances of one input, of sizes 2, 3, 6 and Eigen::Dynamic. They must be finite
/// and symmetric: asymmetry up to 1e-6 of the largest entry, as filters leave it, is averaged away, and counted above 1e-9. A
/// fault is a phrase that follows "the information matrix of edge 3-4".
class InformationCheck {
 public:
  /// A check of matrices in memory: nothing is repaired.
  InformationCheck() = default;
  /// A check for a reader: with `repair`, asymmetric and indefinite matrices are repaired and counted; without it, the fault
  /// names the option.
  explicit InformationCheck(bool repair) : repair_(repair), offer_(!repair) {}

  /// The fault of an information matrix, "is not finite", "is not symmetric …" or "is indefinite …"; nullopt if it is valid.
  /// Round-off passes unchanged: what is definite once each diagonal entry is raised by 1e-9 of itself and 1e-13 of the largest
  /// entry, whatever the units of the rows. A repaired W is the nearest semidefinite matrix (in Frobenius norm: eigenvalues
  /// clipped at zero). One Cholesky factorisation; O(Size³).
  template <int Size>
  std::optional<std::string> fault(Matrix<Size>& W);

  /// Replaces a covariance by its information matrix, or returns its fault, such as "is not positive definite". Repair lifts
  /// the eigenvalues of the correlation matrix to 1e-9 of the largest; the variances must be positive.
  template <int Size>
  std::optional<std::string> invert(Matrix<Size>& covariance);

  /// The repairs so far.
  const MatrixRepairs& repairs() const { return repairs_; }

 private:
  template <int Size>
  std::optional<std::string> make_symmetric(Matrix<Size>& M);
  std::string refusal(std::string fault, const char* remedy) const;

  bool repair_ = false;
  bool offer_ = false;  ///< The fault names the option.
  MatrixRepairs repairs_;
};

/// W scaled to a unit diagonal, so that metres and radians weigh alike: D W D.
template <int Rows>
struct UnitScaled {
  Vector<Rows> scale;  ///< The diagonal of D; 0 for rows that are not measured.
  Matrix<Rows> W;
  /// The largest pivot or eigenvalue that is rounding: 1e-9 for an observation, of fixed size, whose numbers a text may have
  /// rounded; n ε for a local map, of dynamic size, which may be stiff inside and hang softly on its base.
  double rounding;
};
template <int Rows>
UnitScaled<Rows> unit_scaled(const Matrix<Rows>& W);

/// The rank of a positive semidefinite matrix: the number of pivots of its Cholesky factor that are not rounding, scaled to a
/// unit diagonal.
template <int Rows>
std::int64_t information_rank(const Matrix<Rows>& W);

/// The projector onto the range of a positive semidefinite matrix: the identity of what it measures. Zero rows stay zero.
template <int Rows>
Matrix<Rows> measured_identity(const Matrix<Rows>& W);

/// The information of the rows L with N marginalised: W_LL - W_LN W_NN⁻¹ W_NL. It splits rᵀWr into the marginal cost of L and
/// the cost of N given L, which is never negative.
Eigen::MatrixXd marginal_information(const Eigen::MatrixXd& W, const std::vector<Eigen::Index>& L,
                                     const std::vector<Eigen::Index>& N);

}  // namespace mapjoin
