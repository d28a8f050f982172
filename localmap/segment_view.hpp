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
  Index begin = 0;
  Index end = 0;
  std::vector<Index> interior;  ///< Poses that only this segment mentions, ascending.
  std::vector<Index> kept;      ///< Poses after `begin` that stay, ascending; `end` is the last.
  std::vector<Index> features;  ///< Ascending.
  std::span<const PoseFactor<Dim>> odometry;
  std::span<const FeatureFactor<Dim>> observations;

  Index poses() const { return end - begin + 1; }
  /// The place of a feature in `features`.
  std::size_t feature_slot(Index feature) const;
};

/// The odometry and observations of a segment of the log.
template <int Dim>
std::span<const PoseFactor<Dim>> odometry_of(const Log<Dim>& log, const Segment& segment);
template <int Dim>
std::span<const FeatureFactor<Dim>> observations_of(const Log<Dim>& log, const Segment& segment);

template <int Dim>
SegmentView<Dim> segment_view(const Log<Dim>& log, const Split& split, const Segment& segment);

}  // namespace mapjoin
