// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/localmap/check.hpp>
#include <mapjoin/localmap/segment.hpp>

namespace mapjoin {
namespace {

template <int Dim>
bool cover_sessions(const Log<Dim>& log, const std::vector<Stretch>& stretches) {
  auto stretch = stretches.begin();
  for (const Session& session : log.sessions) {
    Index reached = session.begin;
    do {
      if (stretch == stretches.end() || stretch->begin != reached) return false;
      if (stretch->end >= session.end || (stretch->end <= reached && session.end - session.begin > 1)) return false;
      reached = stretch->end;
      ++stretch;
    } while (reached + 1 < session.end);
  }
  return stretch == stretches.end();
}

template <int Dim>
bool is_map_of(const LocalMap<Dim>& map, const Segment<Dim>& segment) {
  return map.base == segment.begin && map.poses == segment.kept && map.features == segment.features;
}

}  // namespace

template <int Dim>
Expected<void> check_local_maps(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps) {
  if (!cover_sessions(log, split.stretches))
    return bad_input(log.source + ": the stretches of the local maps do not cover the log");
  auto map = maps.begin();
  for (const Stretch& stretch : split.stretches) {
    if (!stretch.is_map) continue;
    if (map == maps.end() || !is_map_of(*map, segment_of(log, split, stretch))) {
      return bad_input(fmt::format("{}: the local map from {} is not of this log", log.source,
                                   to_string(log.poses[static_cast<std::size_t>(stretch.begin)])));
    }
    if (const auto wrong = fault(*map)) {
      return bad_input(fmt::format("{}: the local map from {} {}", log.source,
                                   to_string(log.poses[static_cast<std::size_t>(stretch.begin)]), *wrong));
    }
    ++map;
  }
  if (map != maps.end()) return bad_input(log.source + ": there are more local maps than stretches for them");
  return {};
}

template Expected<void> check_local_maps(const Log<2>&, const Split&, const std::vector<LocalMap<2>>&);
template Expected<void> check_local_maps(const Log<3>&, const Split&, const std::vector<LocalMap<3>>&);

}  // namespace mapjoin
