// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut by time: each rank has consecutive poses, with what was measured from them, as a log of its own.

#include <mapjoin/distributed/reading/log_part.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <vector>

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

/// The first pose of each rank's share, where these have as many poses.
std::vector<PoseIndex> even_begins(std::size_t poses, int ranks);

/// The share of this rank, once all have dealt out the factors of their parts, which they give up for it. `begins` is the first
/// pose of each, at which the one before ends.
template <int Dim>
LogShare<Dim> share_of(const Communicator& comm, LogPart<Dim>& part, const std::vector<PoseIndex>& begins, PoseOrder order);

}  // namespace mapjoin::distributed
