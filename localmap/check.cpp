// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/segment_view.hpp>

namespace mapjoin {
namespace {

/// The pose with which the segment behind these begins; the number of poses if there is none. Bad input unless each begins
/// where the one before ends, or else with the next session, and ends later in its session, or with it.
template <int Dim>
Expected<PoseIndex> end_of(const Log<Dim>& log, const std::vector<Segment>& segments) {
  PoseIndex next = 0;
  auto session = log.sessions.begin();
  for (const Segment& segment : segments) {
    const bool is_there = session != log.sessions.end() && segment.begin == next && segment.end < session->end;
    if (!is_there || segment.end < std::min(next + 1, session->end - 1)) {
      return bad_input_of(log.source,
                          fmt::format("segment {} does not run on within its session from where the one before ends",
                                      &segment - segments.data() + 1));
    }
    next = segment.end;
    if (next + 1 == session->end) next = session++->end;
  }
  return next;
}

template <int Dim>
bool is_map_of(const LocalMap<Dim>& map, const SegmentView<Dim>& view) {
  auto features = map.features;
  std::ranges::sort(features);
  return map.base == view.begin && map.poses == view.kept && features == view.features;
}

}  // namespace

template <int Dim>
Expected<void> check_split(const Log<Dim>& log, const Split& split) {
  if (auto sound = check_invariants(log); !sound) return sound;
  if (split.segments.empty()) return bad_input_of(log.source, "its poses are in no segment");
  if (const auto end = end_of(log, split.segments); !end) return tl::unexpected(end.error());
  if (split.kept.size() != log.poses.size()) {
    return bad_input_of(log.source, fmt::format("its split says of {} which of them stay, but there are {}",
                                                plural(split.kept.size(), "pose"), log.poses.size()));
  }
  const auto must_stay = split_along(log, split.segments).kept;
  for (const PoseIndex p : indices(log.poses)) {
    if (must_stay[p] && !split.kept[p]) return bad_input_of(log.source, "its split does not keep " + to_string(log.poses[p]));
  }
  return {};
}

template <int Dim>
Expected<void> check_maps_of_split(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps) {
  if (auto checked = check_split(log, split); !checked) return checked;
  auto map = maps.begin();
  for (const Segment* segment : map_segments(split.segments)) {
    if (map == maps.end() || !is_map_of(*map++, segment_view(log, split, *segment))) {
      return bad_input_of(log.source,
                          fmt::format("the local map from {} is not of this log", to_string(log.poses[segment->begin])));
    }
  }
  if (map != maps.end()) return bad_input_of(log.source, "there are more local maps than segments for them");
  return {};
}

template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps) {
  if (auto checked = check_maps_of_split(log, split, maps); !checked) return checked;
  if (*end_of(log, split.segments) != indices(log.poses).last)
    return bad_input_of(log.source, "the segments of the local maps do not cover the log");
  for (const LocalMap<Dim>& map : maps) {
    const auto wrong = fault(map);
    if (wrong) return bad_input_of(log.source, fmt::format("the local map from {} {}", to_string(log.poses[map.base]), *wrong));
  }
  return {};
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                 \
  template Expected<void> check_split(const Log<Dim>&, const Split&);                                            \
  template Expected<void> check_maps_of_split(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&); \
  template Expected<void> check_local_maps(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
