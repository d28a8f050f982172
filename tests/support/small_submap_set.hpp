// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Small sets of local maps, without their log, and what they see.

#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/association/identities.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <numeric>
#include <utility>
#include <vector>

namespace mapjoin::testing {

/// The local maps and the closures of a log as a set, without anything else of the log.
template <int Dim>
SubmapSet<Dim> small_submap_set(const Log<Dim>& log, double poses_per_map) {
  Split parts = split(log, {SplitRule::kPoses, poses_per_map});
  SubmapSet<Dim> set;
  set.source = "maps";
  set.graph.submaps = build_local_maps<Dim>(log, parts, {}).value().maps;
  // Only kept poses are in the set.
  Table<PoseIndex, PoseIndex> place(log.poses.size(), kWorld);
  for (const PoseIndex p : indices(place)) {
    if (!parts.kept[p]) continue;
    place[p] = PoseIndex(set.poses.size());
    set.poses.push_back(log.poses[p]);
  }
  const auto placed = [&](PoseIndex pose) { return place[pose]; };
  for (auto& map : set.graph.submaps) {
    map.base = placed(map.base);
    for (PoseIndex& pose : map.poses) pose = placed(pose);
    set.segments.push_back({map.base, map.poses.back(), true});
  }
  for (auto closure : log.closures()) {
    closure.base = placed(closure.base);
    closure.target = placed(closure.target);
    set.graph.pose_factors.push_back(closure);
  }
  set.features = log.features;
  return set;
}

/// The sightings of local maps, each of a feature of its own.
template <int Dim>
Identities all_apart(const SubmapSet<Dim>& set) {
  std::vector<Sighting> sightings = sightings_of(set);
  std::vector<std::size_t> labels(sightings.size());
  std::iota(labels.begin(), labels.end(), std::size_t{0});
  return {std::move(sightings), std::move(labels)};
}

}  // namespace mapjoin::testing
