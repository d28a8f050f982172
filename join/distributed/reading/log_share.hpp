// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut by time: each rank has consecutive poses, with the measurements from them, as a log of its own.

#include <mapjoin/distributed/reading/log_part.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <vector>

namespace mapjoin::distributed {

/// The share of one rank. Neighbours share the pose at which one ends and the other begins, as segments do.
template <int Dim>
struct LogShare {
  Log<Dim> log;
  Table<PoseIndex, PoseIndex> poses;           ///< Index among all names, by pose of `log`.
  Table<FeatureIndex, FeatureIndex> features;  ///< Index among all names, by feature of `log`.
  FactorGraph<Dim> apart;                      ///< Closures to other shares, and priors, by the indices of all names.

  Table<PoseIndex, bool> is_referenced;  ///< True for poses of `log` that other ranks, `apart` or the World refer to.
  Table<FeatureIndex, bool> is_referenced_feature;  ///< True for features of `log` that other ranks or priors refer to.
};

/// The first pose of each rank's share, with equally many poses in each.
std::vector<PoseIndex> even_begins(std::size_t poses, int ranks);

/// The share of this rank, from the factors that all ranks deal out of their parts and give up. `begins` holds the first pose
/// of each share, at which the one before ends.
template <int Dim>
LogShare<Dim> share_of(const Communicator& comm, LogPart<Dim>& part, const std::vector<PoseIndex>& begins, PoseOrder order);

}  // namespace mapjoin::distributed
