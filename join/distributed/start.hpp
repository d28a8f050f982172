// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A start for the whole log: every rank aligns the local maps of its share, and the shares are aligned with each other by
// little of what they share.

#include <mapjoin/distributed/share_maps.hpp>

namespace mapjoin::distributed {

/// Values of the poses and features of a share, in the World. Along a tree as one process would: the segments of a share, whose
/// maps are given up for it, by the schedule of `options`, then the shares, aligned rigidly, for which the first rank sees a
/// thousand observations of each.
template <int Dim>
Values<Dim> start_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share, ShareMaps<Dim> maps,
                     const RunOptions& options);

}  // namespace mapjoin::distributed
