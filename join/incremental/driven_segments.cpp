// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/driven_segments.hpp>
#include <set>
#include <string>

namespace mapjoin {
namespace {

template <int Dim>
std::set<PoseId> driven_poses(const SubmapUpdate<Dim>& update) {
  const Segment segment = driven_segment(update);
  return {update.poses.begin() + segment.begin.value, update.poses.begin() + segment.end.value + 1};
}

}  // namespace

template <int Dim>
Expected<void> DrivenSegments<Dim>::check(const SubmapUpdate<Dim>& update) const {
  if (const auto checked = check_update(update); !checked) return checked;
  const Segment segment = driven_segment(update);
  const auto wrong = [&](const PoseId& id, const char* what) { return bad_input_of(update.source, to_string(id) + what); };
  for (const PoseIndex p : indices(update.poses)) {
    const PoseId& id = update.poses[p];
    const auto known = poses_.find(id);
    const bool is_known = known != poses_.end();
    if (p < segment.begin || p > segment.end) {
      if (!is_known) return wrong(id, " is in no segment yet");
    } else if (is_known && p > segment.begin) {
      return wrong(id, " is in a segment already");
    } else if (is_known && !known->second) {
      return wrong(id, " is in a segment already, which does not end there or goes on in another one");
    }
  }
  for (const FixedPose<Dim>& fixed : update.graph.fixed) {
    const auto before = fixed_.find(update.poses[fixed.pose]);
    if (before != fixed_.end() && before->second != fixed.value) return wrong(before->first, " is fixed elsewhere already");
  }
  return {};
}

template <int Dim>
Expected<void> DrivenSegments<Dim>::add(const SubmapUpdate<Dim>& update) {
  return check(update).map([&] {
    const Segment segment = driven_segment(update);
    for (PoseIndex p = segment.begin; p <= segment.end; ++p) poses_[update.poses[p]] = p == segment.end;
    for (const FixedPose<Dim>& fixed : update.graph.fixed) fixed_.emplace(update.poses[fixed.pose], fixed.value);
  });
}

template <int Dim>
Expected<void> DrivenSegments<Dim>::keep_more(const SubmapUpdate<Dim>& update, const SubmapUpdate<Dim>& map) {
  if (const auto checked = check_update(map); !checked) return checked;
  const auto wrong = [&](const std::string& what) { return bad_input_of(map.source, what); };
  const auto is_of_map = [](const SubmapUpdate<Dim>& of) { return !of.segments.empty() && of.segments.front().is_map; };
  if (!is_of_map(map) || !is_of_map(update)) return wrong("a local map can only take the place of another one");
  if (!map.graph.pose_factors.empty() || !map.graph.feature_factors.empty() || !map.graph.fixed.empty()) {
    return wrong("only a local map can take the place of another one: give other factors in an update of their own");
  }
  if (first_pose(map) != first_pose(update) || last_pose(map) != last_pose(update)) {
    return wrong("the map is not of the segment from " + to_string(first_pose(update)) + " to " +
                 key_text(last_pose(update).key));
  }
  std::set<PoseId> added = driven_poses(map);
  for (const PoseId& id : driven_poses(update)) {
    if (added.erase(id) == 0) return wrong(to_string(id) + " was in the map, and is not any more");
  }
  for (const FeatureIndex f : update.graph.submaps.front().features) {
    if (std::ranges::count(map.features, update.features[f]) > 0) continue;
    return wrong(to_string(update.features[f]) + " was in the map, and is not any more");
  }
  for (const PoseId& id : added) {
    if (poses_.contains(id)) return wrong(to_string(id) + " is in a segment already");
  }
  for (const PoseId& id : added) poses_[id] = false;
  return {};
}

template class DrivenSegments<2>;
template class DrivenSegments<3>;

}  // namespace mapjoin
