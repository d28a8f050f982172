// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/associate_stored.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <set>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// By feature of a log, what it is called in the same log under other names.
template <int Dim>
Table<FeatureIndex, FeatureIndex> new_names(const Log<Dim>& log, const Log<Dim>& renamed) {
  Table<FeatureIndex, FeatureIndex> names(log.features.size(), FeatureIndex(0));
  for (std::size_t k = 0; k < log.observations().size(); ++k) {
    names[log.observations()[k].target] = renamed.observations()[k].target;
  }
  return names;
}

/// Whether every feature is seen in several segments.
template <int Dim>
Table<FeatureIndex, bool> shared_features(const StoredMaps<Dim>& stored) {
  Table<FeatureIndex, int> segments(stored.log.features.size(), 0);
  for (const Segment& segment : stored.segments) {
    std::set<FeatureIndex> seen;
    for (const auto& observation : observations_of(stored.log, segment)) seen.insert(observation.target);
    for (const FeatureIndex feature : seen) ++segments[feature];
  }
  Table<FeatureIndex, bool> shared;
  for (const int count : segments) shared.push_back(count > 1);
  return shared;
}

/// Without the maps inside which a shared feature was marginalised: their segments are raw.
template <int Dim>
void give_way(StoredMaps<Dim>& stored) {
  const Table<FeatureIndex, bool> shared = shared_features(stored);
  std::vector<LocalMap<Dim>> kept;
  auto map = stored.maps.begin();
  for (Segment& segment : stored.segments) {
    if (!segment.is_map) continue;
    segment.is_map = std::ranges::none_of(observations_of(stored.log, segment), [&](const FeatureFactor<Dim>& seen) {
      return shared[seen.target] && std::ranges::find(map->features, seen.target) == map->features.end();
    });
    if (segment.is_map) kept.push_back(std::move(*map));
    ++map;
  }
  stored.maps = std::move(kept);
}

}  // namespace

template <int Dim>
Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>& stored, const AssociationOptions& options,
                                                const std::stop_token& stop) {
  if (!options.names_hold) throw std::invalid_argument("local maps that are built by names can be associated where these hold");
  return associate(stored.log, options, stop).map([&](Associated<Log<Dim>>&& found) {
    const auto names = new_names(stored.log, found.data);
    Associated<StoredMaps<Dim>> result{{std::move(found.data), stored.segments, stored.maps, stored.options},
                                       std::move(found.sightings),
                                       found.joins,
                                       std::move(found.untied)};
    for (LocalMap<Dim>& map : result.data.maps) {
      for (FeatureIndex& feature : map.features) feature = names[feature];
    }
    give_way(result.data);
    return result;
  });
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                              \
  template Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>&, const AssociationOptions&, \
                                                           const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
