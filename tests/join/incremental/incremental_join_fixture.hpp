// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Updates of a small world, and the difference of their incremental join from a join of all at once.

#include <gtest/gtest.h>

#include <mapjoin/join/incremental/incremental_join.hpp>
#include <tests/support/batch_join.hpp>
#include <tests/support/small_world.hpp>
#include <vector>

namespace mapjoin::testing {

template <typename D>
class IncrementalJoinFixture : public ::testing::Test {
 protected:
  static constexpr int kDim = D::value;
  using Parts = std::vector<SubmapUpdate<kDim>>;

  static Parts submap_updates_of(const WorldOptions& options, double poses_per_map) {
    return parts_of_log(small_world<kDim>(options).log, poses_per_map);
  }

  static Join<kDim> batch(const Parts& updates) {
    std::vector<const SubmapUpdate<kDim>*> all;
    for (const auto& update : updates) all.push_back(&update);
    return batch_join(all);
  }

  /// A closure between the first poses of two updates.
  static SubmapUpdate<kDim> closure(const SubmapUpdate<kDim>& from, const SubmapUpdate<kDim>& to, const Pose<kDim>& measured,
                                    const PoseMatrix<kDim>& information) {
    SubmapUpdate<kDim> closure;
    closure.poses = {first_pose(from), first_pose(to)};
    closure.graph.pose_factors = {{0, 1, measured, information}};
    return closure;
  }

  /// The largest difference between the estimate and a join of all updates (m, rad).
  static double difference(const IncrementalJoin<kDim>& joined, const Parts& updates) {
    const SubmapSet<kDim> set = set_of_all(updates);
    const Values<kDim> state = batch(updates).state;
    Values<kDim> found;
    for (const PoseId& id : set.poses) found.poses.push_back(*joined.pose(id));
    for (const FeatureId& id : set.features) found.features.push_back(*joined.feature(id));
    return largest_difference(found, state);
  }
};

}  // namespace mapjoin::testing
