// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Little of a partial map, enough to align it with those of other ranks.

#include <mapjoin/distributed/log_part.hpp>
#include <mapjoin/distributed/mpi/communicator.hpp>
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
struct Ties {
  std::vector<PoseFactor<Dim>> closures;
  std::vector<PoseFactor<Dim>> priors;
  std::vector<FixedPose<Dim>> fixed;

  /// All their poses, ascending.
  std::vector<PoseIndex> poses() const;
};

/// At most `most` of a list, spread evenly.
template <typename T>
std::vector<T> evenly_chosen(const std::vector<T>& list, std::size_t most) {
  if (list.size() <= most) return list;
  std::vector<T> chosen;
  for (std::size_t k = 0; k < most; ++k) chosen.push_back(list[k * list.size() / most]);
  return chosen;
}

/// The frame in the World of each outline of this rank: aligned on the first rank, rank with rank along a balanced tree.
template <int Dim>
std::vector<Pose<Dim>> frames_of(const Communicator& comm, const std::vector<Outline<Dim>>& outlines, const Ties<Dim>& ties);

}  // namespace mapjoin::distributed
