// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The objective F of full SLAM (9) and of joining (32): along a line of states, on which headings are not wrapped, and how much
// of it is quadratic.

#include <Eigen/Core>
#include <cstdint>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/model/values.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// A view of an observation or a local map, which are alike: from a base, of poses and features relative to it, with one
/// information matrix over all of them, the poses first.
template <int Dim>
struct IntegratedObservation {
  std::size_t factor;  ///< Its number in the system.
  PoseIndex base;
  std::span<const Pose<Dim>> measured_poses;
  std::span<const PoseIndex> poses;
  std::span<const Point<Dim>> measured_features;
  std::span<const FeatureIndex> features;
  Eigen::Ref<const Eigen::MatrixXd> W;
};

/// Every observation and every map of a system, in the order of its cliques.
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

/// chi2 of every observation and map of a joining system. In the plane the heading residual φ̂ - (φ_t - φ_b) is taken as it is:
/// the turns that are added to φ̂ are those that wrap it at the reference, here and everywhere, so that F is smooth, and chi2
/// near the reference. Rotations in space have no such numbers: their residual is the shortest rotation vector, and F has
/// kinks where one passes π.
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

/// How much of an objective is quadratic in the coordinates of its state (paper's (24), (25), (35)).
///
/// A row of an observation is linear
///
///   - in the absolute state where its base is anchored or the World, for then R(φ_b) is a constant; in the plane, where it is
///   a
///     heading difference;
///   - in the relative state where the relation that it measures is one of the state's, along the spanning tree: odometry,
///   first
///     observations, and of a local map its end pose and the features first seen in it; in the plane, where it is a heading
///     difference, a sum of relations (27).
///
/// Rotations in space are taken as rotation vectors about what was measured of them. Of an observation whose rows L are linear
/// and N are not, the quadratic part is the marginal of L, r_Lᵀ M r_L.
struct QuadraticShare {
  std::int64_t rows = 0;            ///< Measured ones: the rank of every W.
  std::int64_t quadratic_rows = 0;  ///< The rank of every M.
  /// tr(H_Q H⁻¹) / n: H = JᵀWJ is the information of the state, H_Q = J_Lᵀ M J_L that of the quadratic part, n the number of
  /// unknowns. Of all that the estimate knows, what the quadratic part contributes; free of units, and the same in any
  /// coordinates.
  double information = 0.0;

  double of_rows() const { return rows == 0 ? 0.0 : static_cast<double>(quadratic_rows) / static_cast<double>(rows); }
};

/// At the estimate of `system`, which has just been linearised and factorised there.
template <int Dim>
QuadraticShare quadratic_share(const JoiningSystem<Dim>& system, JoinedState state);

}  // namespace mapjoin
