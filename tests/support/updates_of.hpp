// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A whole log as updates.

#include <gtest/gtest.h>

#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <vector>

namespace mapjoin::testing {

/// The updates of a whole log, in local maps of `poses_per_map` poses.
template <int Dim>
std::vector<SubmapUpdate<Dim>> updates_of(const Log<Dim>& log, double poses_per_map) {
  SubmapUpdateMaker<Dim> maker({SplitRule::kPoses, poses_per_map});
  EXPECT_TRUE(maker.add(log));
  return maker.take(true).value();
}

}  // namespace mapjoin::testing
