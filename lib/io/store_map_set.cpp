// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/store_map_set.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// What a store says of the maps beside themselves.
template <int Dim>
Log<Dim> log_of(const MapSet<Dim>& set) {
  Log<Dim> log;
  log.source = set.source;
  log.poses = set.poses;
  log.features = set.features;
  log.sessions = {{0, static_cast<Index>(set.poses.size())}};
  log.fixed = set.fixed;
  log.conventions = set.conventions;
  return log;
}

}  // namespace

template <int Dim>
Expected<void> write_store(const MapSet<Dim>& set, const std::filesystem::path& path) {
  if (!set.pose_observations.empty() || !set.feature_observations.empty()) {
    throw std::invalid_argument("a store holds a set of local maps alone");
  }
  auto store = StoreWriter<Dim>::open(path, log_of(set), set.stretches, "");
  if (!store) return tl::unexpected(store.error());
  for (std::size_t k = store->done().size(); k < set.maps.size(); ++k) {
    if (auto added = store->add(k, set.maps[k]); !added) return added;
  }
  return store->finish();
}

template <int Dim>
bool has_maps_alone(const StoredMaps<Dim>& stored) {
  const Log<Dim>& log = stored.log;
  return !stored.maps.empty() && log.odometry.empty() && log.closures.empty() && log.observations.empty() &&
         log.pose_priors.empty() && log.feature_priors.empty();
}

template <int Dim>
MapSet<Dim> map_set_of(StoredMaps<Dim> stored, const std::filesystem::path& path) {
  MapSet<Dim> set;
  set.source = path.string();
  set.poses = std::move(stored.log.poses);
  set.features = std::move(stored.log.features);
  set.maps = std::move(stored.maps);
  set.fixed = std::move(stored.log.fixed);
  set.stretches = std::move(stored.stretches);
  set.conventions = stored.log.conventions;
  return set;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                              \
  template Expected<void> write_store<Dim>(const MapSet<Dim>&, const std::filesystem::path&); \
  template bool has_maps_alone(const StoredMaps<Dim>&);                                       \
  template MapSet<Dim> map_set_of(StoredMaps<Dim>, const std::filesystem::path&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
