// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log cut in space: each rank has the factors whose base lies in its region.

#include <mapjoin/distributed/holdings.hpp>
#include <mapjoin/distributed/start.hpp>
#include <mapjoin/join/align/gauge.hpp>

namespace mapjoin::distributed {

/// Poses and features by one number, first the poses: by the indices of all names.
struct Numbering {
  std::size_t poses = 0;
  std::size_t features = 0;

  std::size_t count() const { return poses + features; }
  std::int32_t number(PoseIndex pose) const { return pose.value; }
  std::int32_t number(FeatureIndex feature) const { return static_cast<std::int32_t>(poses) + feature.value; }
  bool is_pose(std::int32_t number) const { return number < static_cast<std::int32_t>(poses); }
  PoseIndex pose(std::int32_t number) const { return PoseIndex(number); }
  FeatureIndex feature(std::int32_t number) const { return FeatureIndex(number - static_cast<std::int32_t>(poses)); }
};

template <int Dim>
struct Region {
  Numbering numbering;
  FactorGraph<Dim> graph;          ///< Of this region alone.
  PartialMap<Dim> partial;         ///< What they mention, by the indices of all names, at the start.
  Gauge<Dim> gauge;                ///< Of `partial`.
  std::vector<Holding> interface;  ///< What several regions mention, on all ranks; at the same value in each.
};

/// The regions of a log whose shares and their start are given up for them. Bad input, the same on all ranks, where a feature
/// is never observed.
template <int Dim>
Expected<std::unique_ptr<Region<Dim>>> region_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share,
                                                 Values<Dim> start);

}  // namespace mapjoin::distributed
