// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A log as updates, for tests.

#include <gtest/gtest.h>

#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <vector>

namespace mapjoin::testing {

/// All of the log, in local maps of so many poses.
template <int Dim>
std::vector<SubmapUpdate<Dim>> updates_of(const Log<Dim>& log, double poses_per_map) {
  SubmapUpdateMaker<Dim> maker({SplitRule::kPoses, poses_per_map});
  EXPECT_TRUE(maker.add(log));
  return maker.take(true).value();
}

}  // namespace mapjoin::testing
