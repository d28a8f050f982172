// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Leave-one-out tests of parts of the measurements at an optimum: does a part agree with its prediction by all others?

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Rows of one factor's measurement: all of them, or those of one feature of a local map.
struct MeasuredPart {
  std::size_t factor = 0;  ///< Number of the factor in the normal equations.
  Eigen::Index row = 0;
  Eigen::Index rows = 0;
};

/// The squared Mahalanobis distance of a part from its prediction by everything else.
struct PartTest {
  double chi2 = 0.0;
  int rows = 0;             ///< Directions that the other measurements confirm; 0 if there is nothing to test.
  double redundancy = 0.0;  ///< Redundancy, trace(W_A⁻¹ M_A): the others' share in the information on the part; at most `rows`.
};

/// Tests of parts A of the measurements x̂ = H(x) + w, w ~ N(0, W⁻¹), at the optimum, to first order.
///
/// If the rows E of A are wrong by a shift δ, x̂ = H(x) + E δ + w, its estimate is δ = M_A⁻¹ g_A, and chi2 falls by
///
///   T = g_Aᵀ M_A⁻¹ g_A,   g = W r,   M = W - W J P Jᵀ W,   P = (Jᵀ W J)⁻¹,   g_A = Eᵀ g,   M_A = Eᵀ M E.
///
/// T is chi-square with as many degrees of freedom as A has rows, if nothing is wrong (the mean-shift test of regression;
/// Baarda's data snooping in geodesy). For a whole factor it is the squared Mahalanobis distance of its measurement from its
/// prediction by all others. Without A the rest has g - M_·A M_A⁻¹ g_A and M - M_·A M_A⁻¹ M_A·.
template <int Dim>
class LeaveOneOut {
 public:
  /// Prepares tests at the estimate of `system`, where `equations` have been linearised and factorised; all arguments must
  /// outlive this.
  LeaveOneOut(const JoiningSystem<Dim>& system, const NormalEquations& equations, const Marginals& marginals);

  /// True if rounding hides directions of a factor of which others confirm a millionth or more: its poses are far from the
  /// gauge, or their covariances large beside its own.
  bool is_rounded(std::size_t factor) const;
  /// Solves for those of some factors that others hardly confirm in some direction, which covariances do not show: a sharp
  /// closure of a long loop. It is then tested down to a hundred-millionth of its information, in place of a millionth, or of
  /// what rounding hides (is_rounded()). Factors that alone tie a part of the variables to the rest are passed over, as nothing
  /// predicts them. Makes a solution for each row of such a factor; none once a stop is requested.
  void solve_for_weak(std::span<const std::size_t> factors, const std::stop_token& stop = {});

  /// The chi2 at the optimum of the linearised problem, which the estimate may miss by a little.
  double chi2() const { return chi2_; }
  PartTest test(const MeasuredPart& part) const;
  /// The squared Mahalanobis distance rᵀ (W⁻¹ + J P Jᵀ)⁻¹ r of a factor that had no part in the estimate, from its prediction
  /// at the optimum of the linearised problem.
  PartTest prediction(std::size_t factor) const;
  /// test() of a whole factor that counts in the estimate, prediction() of one that does not.
  PartTest test_whole(std::size_t factor, bool counts) const {
    return counts ? test({factor, 0, rows(factor)}) : prediction(factor);
  }
  /// Leaves a part out of the measurements in all tests that follow. Returns the largest rotation of a pose by all parts that
  /// have been left out (rad).
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
  void solve_for(std::size_t factor);
  /// The estimate's step P Jᵀ W X by shifts X of the parts left out so far, a column each; their rows one part after the other.
  Eigen::MatrixXd moved_by(const Eigen::MatrixXd& shifts) const;
  /// The rows of one factor of M X, with all measurements, where `moved` is moved_by(X); or those of the parts left out.
  Eigen::MatrixXd M_times(const Eigen::MatrixXd& shifts, const Eigen::MatrixXd& moved, std::size_t factor) const;
  Eigen::MatrixXd M_times(const Eigen::MatrixXd& shifts) const;
  /// Subtracts from all g and M the effect of some shifts X, each of a size.
  void subtract(const Eigen::MatrixXd& shifts, const Eigen::MatrixXd& moved, const Eigen::VectorXd& size);

  const JoiningSystem<Dim>& system_;
  const NormalEquations& equations_;
  const Marginals& marginals_;
  Eigen::VectorXd step_;   // to the optimum of the linearised problem
  Eigen::VectorXd moved_;  // from there by all that was left out
  std::vector<MeasuredPart> left_out_;
  Eigen::MatrixXd shifts_;  // X of all parts left out, with Xᵀ M X = I
  double chi2_ = 0.0;
  std::vector<std::size_t> offsets_;  // of g, then M, of each factor in values_
  std::vector<double> values_;
  std::vector<double> least_redundancies_;  // of each factor: shares of W below which directions are not tested
};

/// The least scale, however closely all fit: with an error of zero nothing could be weighed against others.
inline constexpr double kLeastScale = 0.001;

/// The scale of the leave-one-out chi2 of measurements that count as right, relative to their covariances: the largest ratio of
/// several sample quantiles to those of chi-square, so that the tail counts, too, with a margin for a small number of tests. At
/// least kLeastScale and at most 1; 1 if there are too few tests. Only tests of `rows` rows count.
double scale_of(std::span<const PartTest> tests, int rows);

}  // namespace mapjoin
