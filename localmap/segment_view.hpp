// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The part of a log that one local map is made of: full SLAM of one segment.

#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/log.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// Poses begin..end of a log with the odometry and observations that belong to them. Views into the log, which must outlive it.
template <int Dim>
struct SegmentView {
  PoseIndex begin = 0;
  PoseIndex end = 0;
  std::vector<PoseIndex> interior;             ///< Poses that only this segment mentions, ascending.
  std::vector<PoseIndex> kept;                 ///< Poses after `begin` that stay, ascending; `end` is the last.
  Table<FeatureIndex, FeatureIndex> features;  ///< By place in the segment, ascending.
  std::span<const PoseFactor<Dim>> odometry;
  std::span<const FeatureFactor<Dim>> observations;

  std::size_t poses() const { return static_cast<std::size_t>(end - begin) + 1; }
  /// The place in the segment of a pose or feature of the log.
  PoseIndex place(PoseIndex pose) const { return PoseIndex(pose - begin); }
  FeatureIndex place(FeatureIndex feature) const;
};

/// The odometry and observations of a segment of the log.
template <int Dim>
std::span<const PoseFactor<Dim>> odometry_of(const Log<Dim>& log, const Segment& segment);
template <int Dim>
std::span<const FeatureFactor<Dim>> observations_of(const Log<Dim>& log, const Segment& segment);

template <int Dim>
SegmentView<Dim> segment_view(const Log<Dim>& log, const Split& split, const Segment& segment);

}  // namespace mapjoin
