// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/localmap/segment.hpp>

namespace mapjoin {

template <int Dim>
std::size_t Segment<Dim>::feature_slot(Index feature) const {
  return static_cast<std::size_t>(std::lower_bound(features.begin(), features.end(), feature) - features.begin());
}

/// Odometry is in the order of its later pose: those after `begin`, up to `end`.
template <int Dim>
std::span<const PoseObservation<Dim>> odometry_of(const Log<Dim>& log, const Stretch& stretch) {
  const auto by_later_pose = [](Index pose, const PoseObservation<Dim>& o) { return pose < std::max(o.base, o.target); };
  const auto first = std::upper_bound(log.odometry().begin(), log.odometry().end(), stretch.begin, by_later_pose);
  const auto last = std::upper_bound(first, log.odometry().end(), stretch.end, by_later_pose);
  return {first, last};
}

/// Observations are in the order of their pose: those from `begin` to before `end`, or to `end` where the session ends there.
template <int Dim>
std::span<const FeatureObservation<Dim>> observations_of(const Log<Dim>& log, const Stretch& stretch) {
  const auto before = [](const FeatureObservation<Dim>& o, Index pose) { return o.base < pose; };
  const auto session = std::upper_bound(log.sessions.begin(), log.sessions.end(), stretch.begin,
                                        [](Index pose, const Session& s) { return pose < s.end; });
  const Index stop = stretch.end + 1 == session->end ? stretch.end + 1 : stretch.end;
  const auto first = std::lower_bound(log.observations().begin(), log.observations().end(), stretch.begin, before);
  const auto last = std::lower_bound(first, log.observations().end(), stop, before);
  return {first, last};
}

namespace {

/// The different features of observations, ascending.
template <int Dim>
std::vector<Index> features_in(std::span<const FeatureObservation<Dim>> observations) {
  std::vector<Index> features;
  for (const auto& observation : observations) features.push_back(observation.target);
  std::sort(features.begin(), features.end());
  features.erase(std::unique(features.begin(), features.end()), features.end());
  return features;
}

}  // namespace

template <int Dim>
Segment<Dim> segment_of(const Log<Dim>& log, const Split& split, const Stretch& stretch) {
  Segment<Dim> segment;
  segment.begin = stretch.begin;
  segment.end = stretch.end;
  for (Index pose = stretch.begin + 1; pose <= stretch.end; ++pose) {
    (split.kept[static_cast<std::size_t>(pose)] ? segment.kept : segment.interior).push_back(pose);
  }
  segment.odometry = odometry_of(log, stretch);
  segment.observations = observations_of(log, stretch);
  segment.features = features_in(segment.observations);
  return segment;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                      \
  template struct Segment<Dim>;                                                                       \
  template std::span<const PoseObservation<Dim>> odometry_of(const Log<Dim>&, const Stretch&);        \
  template std::span<const FeatureObservation<Dim>> observations_of(const Log<Dim>&, const Stretch&); \
  template Segment<Dim> segment_of(const Log<Dim>&, const Split&, const Stretch&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
