// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a map says of relative poses that nothing in it ties together.

#include <Eigen/Core>
#include <cstddef>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// How closely closures are predicted.
struct PredictionOptions {
  std::size_t places = 50;  ///< Landing places at most, spread over the poses of the map.
  double far = 1e3;         ///< Squared Mahalanobis distance beyond which it need not be known how much farther a closure lies.
};

/// The measured less the predicted relative poses of closures, by a map that they have no part in; their covariances are those
/// of retract()'s steps from the identity. All poses of `system` are in its order; `marginals` are of the last factorisation
/// of its equations. Some are missing once a stop is requested.
///
/// The covariance between two poses is that of either with a landing place, a pose beside one of them, whose columns of H⁻¹
/// are solved for: P_ij ≈ P_ib P_bb⁻¹ P_bj, which is exact where b separates i from j. A closure that is far from its
/// prediction however its ends are correlated has the largest covariance that it could have, and needs no landing place.
template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, const PredictionOptions& options,
                                           const std::stop_token& stop = {});

}  // namespace mapjoin
