// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The objective F of full SLAM (9) and of joining (32) along a line of states, on which headings are not wrapped, and the share
// of it that is quadratic.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/model/values.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// A view of an observation or a local map: poses and features relative to a base, with one information matrix over all of
/// them, the poses first.
template <int Dim>
struct IntegratedObservation {
  std::size_t factor;  ///< Number of its factor in the system.
  PoseIndex base;
  std::span<const Pose<Dim>> measured_poses;
  std::span<const PoseIndex> poses;
  std::span<const Point<Dim>> measured_features;
  std::span<const FeatureIndex> features;
  Eigen::Ref<const Eigen::MatrixXd> W;
};

/// Calls `visit` with every observation and every map of a system, in the order of its factors.
template <int Dim, typename Visit>
void for_each_integrated(const JoiningSystem<Dim>& system, Visit&& visit) {
  using Observation = IntegratedObservation<Dim>;
  std::size_t factor = 0;
  for (const auto& [o, base, target] : system.pose_factors()) {
    visit(Observation{factor++, base, {&o->measured, 1}, {&target, 1}, {}, {}, o->information});
  }
  for (const auto& [o, base, target] : system.feature_factors()) {
    visit(Observation{factor++, base, {}, {}, {&o->measured, 1}, {&target, 1}, o->information});
  }
  for (const auto& placed : system.maps()) {
    const LocalMap<Dim>& map = *placed.map;
    visit(Observation{factor++, placed.base, map.pose_estimates, placed.poses, map.feature_estimates, placed.features,
                      map.information});
  }
}

/// The chi2 of a joining system with headings that are not wrapped. In the plane the heading residual is φ̂ - (φ_t - φ_b) plus
/// the turns that wrap it at the reference, the same for all states, so that F is smooth, and equals chi2 near the reference.
/// In space the residual is the shortest rotation vector, and F has kinks where one passes π.
template <int Dim>
class UnwrappedObjective {
 public:
  /// `system` must outlive the objective.
  UnwrappedObjective(const JoiningSystem<Dim>& system, const Values<Dim>& reference);

  double operator()(const Values<Dim>& state) const;

 private:
  const JoiningSystem<Dim>& system_;
  std::vector<double> turns_;  // (rad) per observed pose, in the order of the system; 0 in space
};

/// The share of an objective that is quadratic in the coordinates of its state (paper's (24), (25), (35)).
///
/// A row of an observation is linear
///
///   - in the absolute state if its base is anchored or the World, as R(φ_b) is a constant then; in the plane also if it is
///     a heading difference;
///   - in the relative state if the relation that it measures is one of the state's, along the spanning tree: odometry,
///     first observations, and of a local map its end pose and the features first seen in it; in the plane also if it is a
///     heading difference, a sum of relations (27).
///
/// Rotations in space are taken as rotation vectors about their measured values. The quadratic part of an observation whose
/// rows L are linear is the marginal of these, r_Lᵀ M r_L.
struct QuadraticShare {
  std::int64_t rows = 0;            ///< Measured rows: the ranks of all W.
  std::int64_t quadratic_rows = 0;  ///< Quadratic rows: the ranks of all M.
  /// The share of the quadratic part in the information, tr(H_Q H⁻¹) / n, where H = JᵀWJ is the information of the state, H_Q =
  /// J_Lᵀ M J_L that of the quadratic part, and n the number of unknowns. It is free of units, and the same in any coordinates.
  double information = 0.0;

  double of_rows() const { return rows == 0 ? 0.0 : static_cast<double>(quadratic_rows) / static_cast<double>(rows); }
};

/// The quadratic share at the estimate of `system`, which has just been linearised and factorised there.
template <int Dim>
QuadraticShare quadratic_share(const JoiningSystem<Dim>& system, JoinedState state);

}  // namespace mapjoin
