// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The order of a log: odometry apart from closures, observations by pose, and the sessions that odometry ties together.

#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Makes what is said of Log's members true of a log whose poses are in order, whose odometry holds all pose-pose edges and
/// whose observations come in any order: parts and sorts them stably, counts repeated edges, finds the sessions. O(n log n).
template <int Dim>
void put_in_order(Log<Dim>& log);

}  // namespace mapjoin
