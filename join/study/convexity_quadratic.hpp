// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How much of an objective is quadratic in the coordinates of its state (paper's (24), (25), (35)).
//
// A row of an observation is linear
//
//   - in the absolute state where its base is held or the World, for then R(φ_b) is a constant; in the plane, where it is a
//     heading difference;
//   - in the relative state where the relation that it measures is one of the state's, along the spanning tree: odometry, first
//     observations, and of a local map its end pose and the features first seen in it; in the plane, where it is a heading
//     difference, a sum of relations (27).
//
// Rotations in space are taken as rotation vectors about what was measured of them. Of an observation whose rows L are linear
// and N are not, the quadratic part is the marginal of L, r_Lᵀ M r_L.

#include <cstdint>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joint_system.hpp>

namespace mapjoin {

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
QuadraticShare quadratic_share(const JointSystem<Dim>& system, JoinedState state);

}  // namespace mapjoin
