// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Which of many doubtful measurements are right, from how well pairs of them agree.
//
// Wrong measurements hardly ever agree by chance, right ones do. With e_kl the evidence (a logarithm of odds) that k and l
// being both right explains what they say better than one of them saying anything, the probabilities q that each is right are
// found as the fixed point (mean field) of q_k = σ(e_k + Σ_l q_l e_kl).

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <numbers>
#include <vector>

namespace mapjoin {

/// The most that one pair may say for or against a measurement (logarithm of odds): none decides alone.
inline constexpr double kMostOfAPair = 5.0;

/// How much likelier a mismatch v is by its covariance Σ than anywhere in a volume V: N(v; 0, sΣ) V, with a scale s of the
/// covariance. Without rows it tells nothing.
struct Evidence {
  double log_at_zero = 0.0;       ///< ln(N(0; 0, Σ) V).
  double squared_distance = 0.0;  ///< vᵀΣ⁻¹v.
  int rows = 0;                   ///< Of v.

  /// The logarithm, between -most and most.
  double at(double scale, double most) const {
    return std::clamp(log_at_zero - 0.5 * (squared_distance / scale + rows * std::log(scale)), -most, most);
  }
};

/// The evidence of a mismatch v; without rows where Σ is not positive definite.
template <int Size>
Evidence evidence(const Vector<Size>& v, const Matrix<Size>& covariance, double volume) {
  const Eigen::LLT<Matrix<Size>> factor(covariance);
  if (factor.info() != Eigen::Success) return {};
  const double log_root_det = factor.matrixLLT().diagonal().array().log().sum();
  return {std::log(volume) - log_root_det - 0.5 * Size * std::log(2.0 * std::numbers::pi), v.dot(factor.solve(v)), Size};
}

/// What is known about a measurement before others are asked.
struct PriorOdds {
  double evidence = 0.0;  ///< That it is right: a logarithm of odds.
  bool is_right = false;  ///< It counts as right,
  bool is_wrong = false;  ///< or wrong, whatever the others say.
};

/// How well a measurement agrees with another one.
struct Agreement {
  std::uint32_t other = 0;
  std::uint32_t group = 0;  ///< Of the other one: those of a group may be mistaken together.
  float evidence = 0.0F;    ///< Logarithm of odds.
};

/// For each measurement its agreements, group by group.
using Agreements = std::vector<std::vector<Agreement>>;

/// Logarithms of the odds that each measurement is right. A group says no more than three pairs may.
std::vector<double> odds_by_agreement(const std::vector<PriorOdds>& priors, const Agreements& agreements);

}  // namespace mapjoin
