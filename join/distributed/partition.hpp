// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Space cut into one region for each rank: parts of the graph of what sees what, with few sights between them.

#include <mapjoin/distributed/log_share.hpp>

namespace mapjoin::distributed {

/// The region of each pose of a share: as many poses in each, but for a few per cent. The first rank sees the graph of the
/// whole log without its numbers, runs of poses taken together where there are more than a million.
template <int Dim>
Table<PoseIndex, std::size_t> regions_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share);

}  // namespace mapjoin::distributed
