// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM as one dense system with numerical Jacobians, to check the structured solvers against.

#include <Eigen/Core>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/values.hpp>
#include <vector>

namespace mapjoin::testing {

/// The residual X̂ - H(X) of the paper's (10) and (11), by rotation matrices.
template <int Dim>
Eigen::VectorXd plain_residual(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target);
template <int Dim>
Eigen::VectorXd plain_residual(const Point<Dim>& measured, const Pose<Dim>& base, const Point<Dim>& target);

/// Normal equations: chi2(x ⊕ δ) ≈ chi2 - 2 gᵀδ + δᵀHδ.
struct DenseEquations {
  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double chi2 = 0.0;
};

/// Observations over a state of which some poses and features are free; a step has the free poses first, then the free
/// features.
template <int Dim>
struct DenseSlam {
  std::vector<PoseFactor<Dim>> pose_factors;
  std::vector<FeatureFactor<Dim>> feature_factors;
  std::vector<PoseIndex> free_poses;
  std::vector<FeatureIndex> free_features;

  Eigen::Index size() const;
  Values<Dim> moved(Values<Dim> state, const Eigen::VectorXd& step) const;
  DenseEquations linearise(const Values<Dim>& state) const;
  /// The optimum by Gauss-Newton, to the last digits; the start must be good.
  Values<Dim> optimum(Values<Dim> state) const;
};

/// All observations of a log. Its fixed poses are held, or pose 0 if it has neither fixed poses nor priors.
template <int Dim>
DenseSlam<Dim> full_slam(const Log<Dim>& log);

/// The normal equations over the entries that stay, after the others were eliminated.
DenseEquations eliminated(const DenseEquations& equations, const std::vector<Eigen::Index>& out,
                          const std::vector<Eigen::Index>& stay);

}  // namespace mapjoin::testing
