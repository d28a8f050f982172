// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joins of all parts at once, to compare incremental joins with.

#include <gtest/gtest.h>

#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/localmap/build.hpp>

namespace mapjoin::testing {

template <int Dim>
std::vector<SubmapUpdate<Dim>> parts_of_log(const Log<Dim>& log, double poses_per_map) {
  Split parts = split(log, {SplitRule::kPoses, poses_per_map});
  const auto maps = build_local_maps<Dim>(log, parts, {}).value();
  return submap_updates_of(log, parts, maps.maps);
}

template <int Dim>
SubmapSet<Dim> set_of_all(const std::vector<SubmapUpdate<Dim>>& parts) {
  std::vector<const SubmapUpdate<Dim>*> all;
  for (const auto& part : parts) all.push_back(&part);
  return set_of(all);
}

/// The join of parts at once; its state has the indices of set_of(). Only the equations of its system may be used: the set that
/// the system refers to is gone.
template <int Dim>
Join<Dim> batch_join(const std::vector<const SubmapUpdate<Dim>*>& parts, const Pose<Dim>& origin = {}) {
  const SubmapSet<Dim> set = set_of(parts);
  const SubmapGraph<Dim> graph = submap_graph_of(set);
  JoinOptions<Dim> options;
  options.origin = origin;
  return join(graph, set.poses, set.features, options).value();
}

/// The chi2 that a join of the first `count` parts at once reaches.
template <int Dim>
double batch_chi2(const std::vector<SubmapUpdate<Dim>>& parts, std::size_t count) {
  std::vector<const SubmapUpdate<Dim>*> first;
  for (std::size_t k = 0; k < count; ++k) first.push_back(&parts[k]);
  return batch_join(first).result.chi2;
}

/// Adds part after part, and expects chi2 within 1 % + 0.5 of the batch optimum, the project's promise, at every k-th step and
/// the last.
template <int Dim>
void expect_optimal_at_every_kth_step(const std::vector<SubmapUpdate<Dim>>& parts, std::size_t k) {
  IncrementalJoin<Dim> joined;
  for (std::size_t added = 1; added <= parts.size(); ++added) {
    const AddedUpdate result = joined.add(parts[added - 1]).value();
    ASSERT_TRUE(result.is_joined) << added;
    ASSERT_TRUE(result.converged) << added;
    if (added % k != 0 && added != parts.size()) continue;
    ASSERT_LT(result.chi2, 1.01 * batch_chi2(parts, added) + 0.5) << added;
  }
}

}  // namespace mapjoin::testing
