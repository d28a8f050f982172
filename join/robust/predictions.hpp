// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a map says of relative poses that nothing in it ties together.

#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/robust/odometry_chain.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The measured less the predicted relative poses of closures, by a map that they have no part in; their covariances are those
/// of retract()'s steps from the identity. All poses of `system` are in its order; `marginals` are of the last factorisation
/// of its equations. Some are missing once a stop is requested.
///
/// A closure whose squared Mahalanobis distance is beyond `far` however its ends are correlated has the largest covariance that
/// it could have: how much farther off it lies need not be known, and how its ends are correlated is not worked out.
template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, double far,
                                           const std::stop_token& stop = {});

}  // namespace mapjoin
