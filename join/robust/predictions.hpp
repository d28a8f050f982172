// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Relative poses that a map predicts for closures that had no part in it.

#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The measured less the predicted relative poses of closures that had no part in a map; their covariances are those of
/// retract()'s steps from the identity. The indices of poses are places in `system`; `marginals` are of the last factorisation
/// of its equations. Some are missing once a stop is requested.
///
/// A closure whose squared Mahalanobis distance is beyond `far` for any correlation of its ends gets the largest covariance
/// that it could have: its exact distance is not needed, and the correlation is not computed.
template <int Dim>
std::vector<UncertainPose<Dim>> mismatches(const JoiningSystem<Dim>& system, const Marginals& marginals,
                                           std::span<const PoseFactor<Dim>> closures, double far,
                                           const std::stop_token& stop = {});

}  // namespace mapjoin
