// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A start for the whole log: every rank builds and aligns the local maps of its share, and the shares are aligned with each
// other by little of what they share.

#include <mapjoin/distributed/log_share.hpp>
#include <mapjoin/join/run.hpp>

namespace mapjoin::distributed {

/// Values of the poses and features of a share, in the World.
template <int Dim>
struct ShareStart {
  Values<Dim> values;
  RunFigures figures;  ///< Of the local maps of this rank.
};

/// Along a tree as one process would: the segments of a share by the schedule of `options`, then the shares, aligned rigidly,
/// for which the first rank sees a thousand observations of each.
template <int Dim>
Expected<ShareStart<Dim>> start_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                   const RunOptions& options);

}  // namespace mapjoin::distributed
