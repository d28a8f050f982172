// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/incremental/driven_segments.hpp>

namespace mapjoin {

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

template class DrivenSegments<2>;
template class DrivenSegments<3>;

}  // namespace mapjoin
