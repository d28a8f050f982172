// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The leaves of a join: each segment of the submap graph as a partial map in the frame of its first pose, from its own
// observations only.

#include <cstddef>
#include <mapjoin/join/align/partial_map.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

/// Finds maps, observations and closures by segment. The graph must outlive this.
template <int Dim>
class Leaves {
 public:
  explicit Leaves(const SubmapGraph<Dim>& graph);

  /// A local map as it is, or a raw segment composed from its odometry, and what single observations from its poses see.
  PartialMap<Dim> partial(std::size_t segment) const;
  /// The pose observations that do not belong to a single raw segment.
  const std::vector<const PoseFactor<Dim>*>& closures() const { return closures_; }
  /// The first and last segment that an observation between two poses ties together.
  std::pair<std::size_t, std::size_t> segments_of(const PoseFactor<Dim>& observation) const;
  std::size_t joined_pose_count() const { return joined_pose_count_; }

 private:
  /// The segment that starts at or contains a pose; the last segment of a session for its last pose.
  std::size_t segment_of(PoseIndex pose) const;
  PartialMap<Dim> partial_of_map(const LocalMap<Dim>& map) const;
  PartialMap<Dim> partial_of_raw(std::size_t segment) const;

  const SubmapGraph<Dim>& graph_;
  std::vector<const LocalMap<Dim>*> maps_;    // per segment, or null
  Table<PoseIndex, std::size_t> segment_of_;  // by pose, from the first segment's first pose to the last one's last
  std::vector<std::vector<const PoseFactor<Dim>*>> odometry_;
  std::vector<std::vector<const FeatureFactor<Dim>*>> observations_;
  std::vector<const PoseFactor<Dim>*> closures_;
  std::size_t joined_pose_count_ = 0;
};

}  // namespace mapjoin
