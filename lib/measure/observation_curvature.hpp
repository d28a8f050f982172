// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Where the term of a single feature observation is convex (paper's (13)-(21)).
//
// With unit covariance the term is f(φ̃, δ) = |R(φ̃)Ẑ - δ|²: φ̃ is the error of the heading, δ = X_f - X_r where the feature is
// seen from the pose, Ẑ where it was measured, turned by the heading as estimated. With u = R(φ̃)Ẑ and its derivative u' (u
// turned by a right angle), the Hessian over (φ̃, δ) is
//
//       ⎡ uᵀδ  -u'ᵀ ⎤
//   2   ⎢           ⎥ ,
//       ⎣ -u'    I  ⎦
//
// and the Schur complement of I in it uᵀδ - |Ẑ|². The term is convex where that is not negative: where the feature stands,
// along the line of sight, at least as far away as it was measured. Every minimum, δ = u, lies on the border. A heading known
// with standard deviation σ_φ adds (σ/σ_φ)² φ̃², σ that of the observation, and moves the border nearer:
//
//   uᵀδ ≥ |Ẑ|² - (σ/σ_φ)².

#include <mapjoin/geometry/rotation.hpp>

namespace mapjoin {

struct ObservationTerm {
  Point<2> measured = Point<2>::Zero();  ///< Ẑ (m)
  double heading_weight = 0.0;           ///< (σ/σ_φ)² (m²)

  /// |R(φ̃)Ẑ - δ|² + heading_weight φ̃².
  double value(double heading_error, const Point<2>& delta) const;
  /// Over (φ̃, δ_x, δ_y).
  Matrix<3> hessian(double heading_error, const Point<2>& delta) const;
  bool is_convex_at(double heading_error, const Point<2>& delta) const;
  /// The least |δ| (m) at which the term is convex, for δ in the direction of Ẑ and |φ̃| < π/2; negative: any.
  double border(double heading_error) const;
};

}  // namespace mapjoin
