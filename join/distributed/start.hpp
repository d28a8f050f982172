// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Initial values for the whole log: every rank aligns the local maps of its share, and the shares are aligned with each other
// by their outlines, a small part of each.

#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/distributed/reading/log_part.hpp>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/join/align/shared_factors.hpp>

namespace mapjoin::distributed {

/// Some poses, features and observations of a partial map, by the indices of all names. The anchor is a pose of this map alone,
/// if it has such a pose: its alignment places the whole map.
template <int Dim>
struct Outline {
  PoseIndex anchor = 0;
  std::vector<PoseIndex> poses;  ///< Ascending, as are the features.
  std::vector<FeatureIndex> features;
  Values<Dim> values;
  std::vector<FeatureFactor<Dim>> observations;
};

/// Factors by which the outlines of all ranks are aligned, besides the outlines: at most SharedFactors::kMost of a kind from
/// each rank.
template <int Dim>
struct GlobalFactors {
  std::vector<PoseFactor<Dim>> closures;
  std::vector<PoseFactor<Dim>> priors;
  std::vector<FixedPose<Dim>> fixed;

  /// The poses of all these factors, ascending.
  std::vector<PoseIndex> poses() const;
};

/// The frame in the World of each outline of this rank. The first rank aligns them, rank with rank along a balanced tree.
template <int Dim>
std::vector<Pose<Dim>> frames_of(const Communicator& comm, const std::vector<Outline<Dim>>& outlines,
                                 const GlobalFactors<Dim>& factors);

/// Initial values of the poses and features of a share, in the World. They are joined along a tree, as in one process: first
/// the segments of the share, by the schedule of `options`; then the shares, rigidly, by at most a thousand observations of
/// each, which the first rank sees. The maps are given up.
template <int Dim>
Values<Dim> start_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share, ShareMaps<Dim> maps,
                     const RunOptions& options);

}  // namespace mapjoin::distributed
