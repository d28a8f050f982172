// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Space cut into regions: parts of the graph of what sees what, with few sights between them.

#include <mapjoin/distributed/log_share.hpp>

namespace mapjoin::distributed {

/// Of so many regions the one of each pose of a share: as many poses in each, but for a few per cent. The first rank sees the
/// graph of the whole log without its numbers, runs of poses taken together where there are more than a million.
template <int Dim>
Table<PoseIndex, std::size_t> region_of_poses(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                              std::size_t count);

}  // namespace mapjoin::distributed
