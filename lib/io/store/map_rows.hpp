// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Local maps from the rows of a store that is not trusted.

#include <algorithm>
#include <mapjoin/io/store/database.hpp>
#include <mapjoin/io/store/records.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/segment.hpp>
#include <optional>
#include <utility>
#include <vector>

namespace mapjoin::store {

/// The map of a row; nullopt if the sizes of its parts do not agree.
template <int Dim>
std::optional<LocalMap<Dim>> map_of(const Statement& row) {
  LocalMap<Dim> map;
  map.base = PoseIndex(row.integer(1));
  map.chi2 = row.number(2);
  if (!decode_all(row.bytes(3), map.poses) || !decode_all(row.bytes(4), map.features) ||
      !decode_all(row.bytes(5), map.pose_estimates) || !decode_all(row.bytes(6), map.feature_estimates)) {
    return std::nullopt;
  }
  auto information = decode_upper(row.bytes(7), map.row(map.poses.size() + map.features.size()));
  if (!information) return std::nullopt;
  map.information = std::move(*information);
  return map;
}

/// True if a map is one of `segment`, over its poses and some of the features, with valid numbers.
template <int Dim>
bool is_map_of(const LocalMap<Dim>& map, const Segment& segment, IndexRange<FeatureIndex> all) {
  PoseIndex last = segment.begin;
  for (const PoseIndex pose : map.poses) {
    if (pose <= last || pose > segment.end) return false;
    last = pose;
  }
  std::vector<FeatureIndex> features = map.features;
  std::sort(features.begin(), features.end());
  const bool is_once = std::adjacent_find(features.begin(), features.end()) == features.end();
  const bool is_known = std::ranges::all_of(features, [&](FeatureIndex f) { return all.contains(f); });
  return map.base == segment.begin && last == segment.end && is_once && is_known && !fault(map);
}

}  // namespace mapjoin::store
