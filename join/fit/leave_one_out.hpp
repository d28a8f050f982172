// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Leave-one-out tests of parts of the measurements at an optimum: does a part agree with what all the others say of it?

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// Rows of one factor's measurement: all of an observation's, those of one feature of a local map.
struct MeasuredPart {
  std::size_t factor = 0;  ///< As the normal equations count them.
  Eigen::Index row = 0;
  Eigen::Index rows = 0;
};

/// The squared Mahalanobis distance of a part from its prediction by everything else.
struct PartTest {
  double chi2 = 0.0;
  int rows = 0;             ///< Directions that the others confirm; without any there is nothing to test.
  double redundancy = 0.0;  ///< What the others tell of what the part and they tell together, trace(W_A⁻¹ M_A): at most `rows`.
};

/// Tests of parts A of the measurements x̂ = H(x) + w, w ~ N(0, W⁻¹), at the optimum, to first order.
///
/// Were the rows E of A wrong by a shift δ, x̂ = H(x) + E δ + w, its estimate would be δ = M_A⁻¹ g_A, and chi2 would fall by
///
///   T = g_Aᵀ M_A⁻¹ g_A,   g = W r,   M = W - W J P Jᵀ W,   P = (Jᵀ W J)⁻¹,   g_A = Eᵀ g,   M_A = Eᵀ M E:
///
/// chi-square with as many degrees of freedom as A has rows, if nothing is wrong (the mean-shift test of regression; Baarda's
/// data snooping in geodesy). For a whole factor T is the squared Mahalanobis distance of its measurement from its prediction
/// by all others. Leaving A out leaves g - M_·A M_A⁻¹ g_A and M - M_·A M_A⁻¹ M_A· for the rest.
template <int Dim>
class LeaveOneOut {
 public:
  /// At the estimate of `system`, by the last factorisation of `equations`, which were linearised there; all must stay.
  LeaveOneOut(const JoiningSystem<Dim>& system, const NormalEquations& equations, const Marginals& marginals);

  /// chi2 at the optimum of the linearised problem, which the estimate may miss by a little.
  double chi2() const { return chi2_; }
  PartTest test(const MeasuredPart& part) const;
  /// The squared Mahalanobis distance rᵀ (W⁻¹ + J P Jᵀ)⁻¹ r of a factor that had no part in the estimate, from its prediction
  /// at that optimum.
  PartTest prediction(std::size_t factor) const;
  /// Takes a part out of the measurements, for all tests that follow. Returns by how much that turns a pose at most (rad).
  double leave_out(const MeasuredPart& part);

 private:
  std::size_t factor_count() const { return equations_.pattern().factors.size(); }
  Eigen::Index rows(std::size_t factor) const { return system_.rows(factor); }
  auto g(std::size_t factor) { return Eigen::Map<Eigen::VectorXd>(values_.data() + offsets_[factor], rows(factor)); }
  auto g(std::size_t factor) const {
    return Eigen::Map<const Eigen::VectorXd>(values_.data() + offsets_[factor], rows(factor));
  }
  auto M(std::size_t factor) {
    return Eigen::Map<Eigen::MatrixXd>(values_.data() + offsets_[factor] + rows(factor), rows(factor), rows(factor));
  }
  auto M(std::size_t factor) const {
    return Eigen::Map<const Eigen::MatrixXd>(values_.data() + offsets_[factor] + rows(factor), rows(factor), rows(factor));
  }
  /// Subtracts what some columns of M B, B those of the part that is left out, take from all g and M.
  void subtract(std::size_t own, const Eigen::MatrixXd& W_B, const Eigen::MatrixXd& P_Jt_W_B, const Eigen::VectorXd& shift);

  const JoiningSystem<Dim>& system_;
  const NormalEquations& equations_;
  const Marginals& marginals_;
  Eigen::VectorXd step_;  // to the optimum of the linearised problem
  double chi2_ = 0.0;
  std::vector<std::size_t> offsets_;  // of g, then M, factor by factor, in values_
  std::vector<double> values_;
};

/// No scale is less than this, however closely all fit: an error of zero would leave nothing to weigh others by.
inline constexpr double kLeastScale = 0.001;

/// By how much the leave-one-out tests of measurements that count as right are smaller than covariances say: the largest of the
/// ratios of several quantiles, so that the tail counts, too, with a margin for how few they are; at most 1, and 1 where they
/// are too few to tell. Only tests of `rows` rows are looked at.
double scale_of(std::span<const PartTest> tests, int rows);

}  // namespace mapjoin
