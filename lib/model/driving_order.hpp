// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The order in which a robot drove its poses, where their ids do not tell it.

#include <mapjoin/model/log.hpp>

namespace mapjoin {

/// Where fewer than half of the steps from id to id, which are in ascending order, have an edge, and paths along the edges tie
/// half of the poses or more (PathCover, within each of the user's sessions): puts the poses in their order. The pose factors
/// are in the order of the file. O(n log n).
template <int Dim>
void take_order_of_edges(Log<Dim>& log);

}  // namespace mapjoin
