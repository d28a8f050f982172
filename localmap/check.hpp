// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether local maps that were kept somewhere are those of a log.

#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <vector>

namespace mapjoin {

/// Bad input unless the segments cover every session from its first pose to its last, each beginning where the one before
/// ends, and the maps are one per segment that is a map, in order, over the poses and features of its segment. `split` as
/// split_along made it.
template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps);

}  // namespace mapjoin
