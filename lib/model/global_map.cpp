// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/model/global_map.hpp>
#include <stdexcept>

namespace mapjoin {
namespace {

/// One for each of `all`.
template <typename List, typename All>
void demand_each(const List& list, const All& all, const char* what) {
  if (list.size() == all.size()) return;
  throw std::invalid_argument(fmt::format("a map has {} {}, but {} of these", list.size(), what, all.size()));
}

/// One for each of `all`, or none.
template <typename List, typename All>
void demand_all_or_none(const List& list, const All& all, const char* what) {
  if (!list.empty()) demand_each(list, all, what);
}

}  // namespace

template <int Dim>
void demand_whole(const GlobalMap<Dim>& map) {
  demand_each(map.pose_ids, map.poses, "names of poses");
  demand_each(map.feature_ids, map.features, "names of features");
  demand_all_or_none(map.stamps_ns, map.poses, "stamps of poses");
  demand_all_or_none(map.pose_covariances, map.poses, "covariances of poses");
  demand_all_or_none(map.feature_covariances, map.features, "covariances of features");
  const auto is_missing = [&](PoseIndex pose) { return pose.position() >= map.poses.size(); };
  if (std::ranges::any_of(map.gauge, is_missing)) throw std::invalid_argument("a map is anchored at a pose that is not in it");
}

template void demand_whole(const GlobalMap<2>&);
template void demand_whole(const GlobalMap<3>&);

}  // namespace mapjoin
