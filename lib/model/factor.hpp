// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Observations of one target from one base: odometry, closures and priors (a pose), feature observations (a point).
//
// Every observation is X̂ = H(X) + w, w ~ N(0, W⁻¹), where H stacks R_bᵀ(t_t - t_b) and, for a pose, the relative rotation
// R_bᵀ R_t (paper's (10), (11)). Its residual is r = X̂ - H(X): translation in the frame of the base; rotation
// Log((R_bᵀ R_t)ᵀ R̂), in 2D the heading difference wrapped to [-π, π].

#include <mapjoin/geometry/pose.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/loss.hpp>

namespace mapjoin {

/// A relative pose: odometry, closure, or, from the World, a prior of a pose. Rows that were not measured
/// (the rotation of a GPS position, say) have zero rows and columns in `information`.
template <int Dim>
struct PoseFactor {
  PoseIndex base = kWorld;
  PoseIndex target = 0;
  Pose<Dim> measured;           ///< Target in the frame of the base.
  PoseMatrix<Dim> information;  ///< W, symmetric positive semidefinite (1/m², 1/(m rad), 1/rad²).
  Loss loss = {};
};

/// The position of a feature in the frame of the pose that saw it or, from the World, a prior of a feature.
template <int Dim>
struct FeatureFactor {
  PoseIndex base = kWorld;
  FeatureIndex target = 0;
  Point<Dim> measured;           ///< Feature in the frame of the base (m).
  PointMatrix<Dim> information;  ///< W, symmetric positive semidefinite (1/m²).
  Loss loss = {};
};

}  // namespace mapjoin
