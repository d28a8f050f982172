// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Weak information on what may be undetermined in a map of measurements that are in doubt.

#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// The share of the information of a typical edge that weak information is.
inline constexpr double kWeakShare = 1e-9;

/// Weak information on a relative pose, row by row: a share of the median of the edges that measure the row; where none does,
/// that its poses are no farther apart than the map is large, and not turned by more than a turn.
template <int Dim>
PoseVector<Dim> weak_information(const Log<Dim>& log);

/// Adds weak information to an edge that measures only part of a relative pose, in case nothing else that counts measures the
/// rest: `weak` to rows that are not measured, and the same share of its own to the others.
template <int Dim>
void complete_weakly(PoseFactor<Dim>& edge, const PoseVector<Dim>& weak);

}  // namespace mapjoin
