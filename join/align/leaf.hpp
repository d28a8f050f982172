// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The leaves of a join: each stretch of the network as a piece in the frame of its first pose, from nothing but its own
// observations.

#include <cstddef>
#include <mapjoin/join/align/piece.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// Finds maps, observations and closures by stretch. `network` must outlive it.
template <int Dim>
class Leaves {
 public:
  explicit Leaves(const Network<Dim>& network);

  /// A local map as it is, or a span composed from its odometry and first observations.
  Piece<Dim> piece(std::size_t stretch) const;
  /// The pose observations that are of no one span.
  const std::vector<const PoseObservation<Dim>*>& closures() const { return closures_; }
  /// The first and last stretch that an observation between two poses concerns.
  std::pair<std::size_t, std::size_t> stretches_of(const PoseObservation<Dim>& observation) const;
  std::size_t joined_pose_count() const { return joined_pose_count_; }

 private:
  /// The stretch that starts at or contains a pose; of a session's last pose, its last stretch.
  std::size_t stretch_of(Index pose) const;
  Piece<Dim> map_piece(const LocalMap<Dim>& map) const;
  Piece<Dim> span_piece(std::size_t stretch) const;

  const Network<Dim>& network_;
  std::vector<const LocalMap<Dim>*> maps_;  // per stretch, or null
  std::vector<Index> stretch_of_;           // per pose from the first stretch's first one to the last one's last
  std::vector<std::vector<const PoseObservation<Dim>*>> odometry_;
  std::vector<std::vector<const FeatureObservation<Dim>*>> observations_;
  std::vector<const PoseObservation<Dim>*> closures_;
  std::size_t joined_pose_count_ = 0;
};

}  // namespace mapjoin
