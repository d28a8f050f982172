// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/incremental/driven_segments.hpp>

namespace mapjoin {

template <int Dim>
Expected<void> DrivenSegments::check(const SubmapUpdate<Dim>& update) const {
  if (const auto checked = check_update(update); !checked) return checked;
  const Segment segment = driven_segment(update);
  for (const PoseIndex p : indices(update.poses)) {
    const PoseId& id = update.poses[p];
    const auto known = poses_.find(id);
    const bool is_known = known != poses_.end();
    const auto wrong = [&](const char* what) { return bad_input(update.source + ": " + to_string(id) + what); };
    if (p < segment.begin || p > segment.end) {
      if (!is_known) return wrong(" is in no segment yet");
    } else if (is_known && p > segment.begin) {
      return wrong(" is in a segment already");
    } else if (is_known && !known->second) {
      return wrong(" is in a segment already, which does not end there or goes on in another one");
    }
  }
  return {};
}

template <int Dim>
Expected<void> DrivenSegments::add(const SubmapUpdate<Dim>& update) {
  return check(update).map([&] {
    const Segment segment = driven_segment(update);
    for (PoseIndex p = segment.begin; p <= segment.end; ++p) poses_[update.poses[p]] = p == segment.end;
  });
}

template Expected<void> DrivenSegments::check(const SubmapUpdate<2>&) const;
template Expected<void> DrivenSegments::check(const SubmapUpdate<3>&) const;
template Expected<void> DrivenSegments::add(const SubmapUpdate<2>&);
template Expected<void> DrivenSegments::add(const SubmapUpdate<3>&);

}  // namespace mapjoin
