// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The objective F of full SLAM (9) and of joining (32) along a line of states, on which headings are not wrapped.

#include <mapjoin/join/joint_system.hpp>
#include <mapjoin/model/state.hpp>
#include <vector>

namespace mapjoin {

/// chi2 of every observation and map of a joining system. In the plane the heading residual φ̂ - (φ_t - φ_b) is taken as it is:
/// the turns that are added to φ̂ are those that wrap it at the reference, here and everywhere, so that F is smooth, and chi2
/// near the reference. Rotations in space have no such numbers: their residual is the shortest rotation vector, and F has
/// kinks where one passes π.
template <int Dim>
class UnwrappedObjective {
 public:
  /// `system` must outlive the objective.
  UnwrappedObjective(const JointSystem<Dim>& system, const State<Dim>& reference);

  double operator()(const State<Dim>& state) const;

 private:
  PoseVector<Dim> unwrapped(const Pose<Dim>& measured, const Pose<Dim>& base, const Pose<Dim>& target, std::size_t pose) const;
  double map_chi2(const typename JointSystem<Dim>::PlacedMap& placed, const State<Dim>& state, std::size_t first_pose) const;

  const JointSystem<Dim>& system_;
  std::vector<double> turns_;  // (rad) per observed pose, in the order of the system; 0 in space
};

}  // namespace mapjoin
