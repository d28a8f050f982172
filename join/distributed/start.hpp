// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A start for the whole log: every rank aligns the local maps of its share, and the shares are aligned with each other by
// their outlines, little of each.

#include <mapjoin/distributed/mpi/communicator.hpp>
#include <mapjoin/distributed/reading/log_part.hpp>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/join/align/shared_factors.hpp>

namespace mapjoin::distributed {

/// Some poses, features and observations of a partial map, by the indices of all names. The anchor is a pose of this one alone,
/// where it has such a pose: where it comes to stand, the whole does.
template <int Dim>
struct Outline {
  PoseIndex anchor = 0;
  std::vector<PoseIndex> poses;  ///< Ascending, as the features.
  std::vector<FeatureIndex> features;
  Values<Dim> values;
  std::vector<FeatureFactor<Dim>> observations;
};

/// What the outlines of all ranks are aligned by beside themselves: at most SharedFactors::kMost of a kind from each rank.
template <int Dim>
struct GlobalFactors {
  std::vector<PoseFactor<Dim>> closures;
  std::vector<PoseFactor<Dim>> priors;
  std::vector<FixedPose<Dim>> fixed;

  /// All their poses, ascending.
  std::vector<PoseIndex> poses() const;
};

/// The frame in the World of each outline of this rank: aligned on the first rank, rank with rank along a balanced tree.
template <int Dim>
std::vector<Pose<Dim>> frames_of(const Communicator& comm, const std::vector<Outline<Dim>>& outlines,
                                 const GlobalFactors<Dim>& factors);

/// Values of the poses and features of a share, in the World. Along a tree as one process would: the segments of a share, whose
/// maps are given up for it, by the schedule of `options`, then the shares, aligned rigidly, for which the first rank sees a
/// thousand observations of each.
template <int Dim>
Values<Dim> start_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share, ShareMaps<Dim> maps,
                     const RunOptions& options);

}  // namespace mapjoin::distributed
