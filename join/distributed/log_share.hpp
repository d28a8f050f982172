// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut by time: each rank has consecutive poses, with what was measured from them, as a log of its own.

#include <mapjoin/distributed/log_part.hpp>

namespace mapjoin::distributed {

/// Neighbours share the pose at which one ends and the other begins, as segments do.
template <int Dim>
struct LogShare {
  Log<Dim> log;
  Table<PoseIndex, PoseIndex> poses;           ///< Of each pose of `log`, its index among all names.
  Table<FeatureIndex, FeatureIndex> features;  ///< Likewise.
  FactorGraph<Dim> apart;                      ///< By the indices of all names: closures to other shares, and priors.

  Table<PoseIndex, bool> is_referenced;             ///< Poses of `log` that other ranks, `apart` or the World refer to.
  Table<FeatureIndex, bool> is_referenced_feature;  ///< Likewise.
};

/// The share of this rank, once all have dealt out the factors of their parts, which they give up for it.
template <int Dim>
LogShare<Dim> share_of(const Communicator& comm, LogPart<Dim>& part);

}  // namespace mapjoin::distributed
