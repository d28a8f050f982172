// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/lists.hpp>

namespace mapjoin {

template <int Dim>
FeatureIndex SegmentView<Dim>::place(FeatureIndex feature) const {
  return FeatureIndex(std::lower_bound(features.begin(), features.end(), feature) - features.begin());
}

/// Odometry whose later pose is after `begin`, up to `end`; the log has it in the order of that pose.
template <int Dim>
std::span<const PoseFactor<Dim>> odometry_of(const Log<Dim>& log, const Segment& segment) {
  const auto by_later_pose = [](PoseIndex pose, const PoseFactor<Dim>& o) { return pose < later_pose(o); };
  const auto first = std::upper_bound(log.odometry().begin(), log.odometry().end(), segment.begin, by_later_pose);
  const auto last = std::upper_bound(first, log.odometry().end(), segment.end, by_later_pose);
  return {first, last};
}

/// Observations from `begin` to before `end`, or to `end` if the session ends there; the log has them in the order of their
/// pose.
template <int Dim>
std::span<const FeatureFactor<Dim>> observations_of(const Log<Dim>& log, const Segment& segment) {
  const auto before = [](const FeatureFactor<Dim>& o, PoseIndex pose) { return o.base < pose; };
  const auto session = std::upper_bound(log.sessions.begin(), log.sessions.end(), segment.begin,
                                        [](PoseIndex pose, const Session& s) { return pose < s.end; });
  const PoseIndex stop = segment.end + 1 == session->end ? segment.end + 1 : segment.end;
  const auto first = std::lower_bound(log.observations().begin(), log.observations().end(), segment.begin, before);
  const auto last = std::lower_bound(first, log.observations().end(), stop, before);
  return {first, last};
}

namespace {

/// The distinct features of observations, ascending.
template <int Dim>
Table<FeatureIndex, FeatureIndex> features_in(std::span<const FeatureFactor<Dim>> observations) {
  Table<FeatureIndex, FeatureIndex> features;
  for (const auto& observation : observations) features.push_back(observation.target);
  make_distinct(features);
  return features;
}

}  // namespace

template <int Dim>
SegmentView<Dim> segment_view(const Log<Dim>& log, const Split& split, const Segment& segment) {
  SegmentView<Dim> view;
  view.begin = segment.begin;
  view.end = segment.end;
  for (PoseIndex pose = segment.begin + 1; pose <= segment.end; ++pose) {
    (split.kept[pose] ? view.kept : view.interior).push_back(pose);
  }
  view.odometry = odometry_of(log, segment);
  view.observations = observations_of(log, segment);
  view.features = features_in(view.observations);
  return view;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                 \
  template struct SegmentView<Dim>;                                                              \
  template std::span<const PoseFactor<Dim>> odometry_of(const Log<Dim>&, const Segment&);        \
  template std::span<const FeatureFactor<Dim>> observations_of(const Log<Dim>&, const Segment&); \
  template SegmentView<Dim> segment_view(const Log<Dim>&, const Split&, const Segment&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
