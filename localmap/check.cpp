// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/segment_view.hpp>

namespace mapjoin {
namespace {

template <int Dim>
bool cover_sessions(const Log<Dim>& log, const std::vector<Segment>& segments) {
  auto segment = segments.begin();
  for (const Session& session : log.sessions) {
    PoseIndex reached = session.begin;
    do {
      if (segment == segments.end() || segment->begin != reached) return false;
      if (segment->end >= session.end || (segment->end <= reached && session.end - session.begin > 1)) return false;
      reached = segment->end;
      ++segment;
    } while (reached + 1 < session.end);
  }
  return segment == segments.end();
}

template <int Dim>
bool is_map_of(const LocalMap<Dim>& map, const SegmentView<Dim>& view) {
  auto features = map.features;
  std::ranges::sort(features);
  return map.base == view.begin && map.poses == view.kept && features == view.features;
}

}  // namespace

template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps) {
  if (!cover_sessions(log, split.segments))
    return bad_input_of(log.source, "the segments of the local maps do not cover the log");
  auto map = maps.begin();
  for (const Segment& segment : split.segments) {
    if (!segment.is_map) continue;
    if (map == maps.end() || !is_map_of(*map, segment_view(log, split, segment))) {
      return bad_input(
          fmt::format("{}: the local map from {} is not of this log", log.source, to_string(log.poses[segment.begin])));
    }
    if (const auto wrong = fault(*map)) {
      return bad_input(fmt::format("{}: the local map from {} {}", log.source, to_string(log.poses[segment.begin]), *wrong));
    }
    ++map;
  }
  if (map != maps.end()) return bad_input_of(log.source, "there are more local maps than segments for them");
  return {};
}

template Expected<void> check_local_maps(const Log<2>&, const Split&, const std::vector<LocalMap<2>>&);
template Expected<void> check_local_maps(const Log<3>&, const Split&, const std::vector<LocalMap<3>>&);

}  // namespace mapjoin
