// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Finds which of many doubtful measurements are right, from how well pairs of them agree.
//
// Wrong measurements hardly ever agree by chance; right ones do. Let e_kl be the log-odds that k and l are both right, rather
// than one of them anywhere. The probabilities q that each is right are the fixed point (mean field) of q_k = σ(e_k + Σ_l q_l
// e_kl).

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <mapjoin/geometry/pose.hpp>
#include <numbers>
#include <vector>

namespace mapjoin {

/// Bound on the evidence of one pair for or against a measurement (log-odds): no pair decides alone.
inline constexpr double kMostOfAPair = 5.0;

/// The log-odds ln(N(v; 0, sΣ) V) of a mismatch v: its density by the covariance Σ, scaled by s, over that of the uniform
/// distribution in a volume V. Zero without rows.
struct Evidence {
  double log_at_zero = 0.0;       ///< ln(N(0; 0, Σ) V).
  double squared_distance = 0.0;  ///< vᵀΣ⁻¹v.
  int rows = 0;                   ///< Dimension of v.

  /// The log-odds with Σ scaled by `scale`, clamped to [-most, most].
  double at(double scale, double most) const {
    return std::clamp(log_at_zero - 0.5 * (squared_distance / scale + rows * std::log(scale)), -most, most);
  }
};

/// The evidence of a mismatch v; without rows if Σ is not positive definite.
template <int Size>
Evidence evidence(const Vector<Size>& v, const Matrix<Size>& covariance, double volume) {
  const Eigen::LLT<Matrix<Size>> factor(covariance);
  if (factor.info() != Eigen::Success) return {};
  const double log_root_det = factor.matrixLLT().diagonal().array().log().sum();
  return {std::log(volume) - log_root_det - 0.5 * Size * std::log(2.0 * std::numbers::pi), v.dot(factor.solve(v)), Size};
}

/// Knowledge of a measurement before its agreement with others.
struct PriorOdds {
  double evidence = 0.0;  ///< Log-odds that it is right.
  bool is_right = false;  ///< Known to be right, whatever the others say.
  bool is_wrong = false;  ///< Known to be wrong, whatever the others say.
};

/// The agreement of a measurement with another one.
struct Agreement {
  std::uint32_t other = 0;
  std::uint32_t group = 0;  ///< Group of the other one: members of a group may be wrong together.
  float evidence = 0.0F;    ///< Log-odds.
};

/// The agreements of each measurement, group by group.
using Agreements = std::vector<std::vector<Agreement>>;

/// Log-odds that each measurement is right. The evidence of a group is bounded by that of three pairs.
std::vector<double> odds_by_agreement(const std::vector<PriorOdds>& priors, const Agreements& agreements);

}  // namespace mapjoin
