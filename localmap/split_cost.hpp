// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The cost model by which `auto` chooses how many steps a local map takes (docs/decisions.md).

#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

/// What a map of N steps costs per step of the log, in units of one sparse floating-point operation, from a sample of the log:
///   ( 4 (30 m² + 0.4 m³) + 5 (2 N dof m² + 0.5 m³) ) / N,
/// where m is the size of a map's border (kept poses and features). The first term is assembling and factorising the map in the
/// join, four times; the others are eliminating its interior and factorising its border, five times while it is built,
/// recovered and polished. `kept` says which poses the rest of the log mentions; they are in the border, too. A segment that
/// would stay a raw segment costs what its one-step maps do, in the join only.
template <int Dim>
double cost_per_step(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, int poses_per_map);

/// The least number of steps among those of 1, 2, 3, 5, 7, 10, 15, 20, 30, 45, 70, 100 that are at least `fewest` whose cost is
/// within a hundredth of the cheapest; 100 where there is none.
template <int Dim>
int cheapest_poses_per_map(const Log<Dim>& log, const Table<PoseIndex, bool>& kept, double fewest);

}  // namespace mapjoin
