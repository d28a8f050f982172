// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The cost model by which `auto` chooses how many steps a local map takes (docs/decisions.md).

#include <mapjoin/model/log.hpp>

namespace mapjoin {

template <int Dim>
Index cheapest_poses_per_map(const Log<Dim>& log);

}  // namespace mapjoin
