// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/association/associate.hpp>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// The features of `renamed`, the same log under other names, by feature of `log`.
template <int Dim>
Table<FeatureIndex, FeatureIndex> new_names(const Log<Dim>& log, const Log<Dim>& renamed) {
  Table<FeatureIndex, FeatureIndex> names(log.features.size(), FeatureIndex(0));
  for (std::size_t k = 0; k < log.observations().size(); ++k) {
    names[log.observations()[k].target] = renamed.observations()[k].target;
  }
  return names;
}

}  // namespace

template <int Dim>
Expected<Associated<StoredMaps<Dim>>> associate(const StoredMaps<Dim>& stored, const AssociationOptions& options,
                                                const std::stop_token& stop) {
  if (!options.names_hold) throw std::invalid_argument("local maps that are built by names can be associated where these hold");
  return associate(stored.log, options, stop).map([&](Associated<Log<Dim>>&& found) {
    const auto names = new_names(stored.log, found.data);
    Associated<StoredMaps<Dim>> result{{std::move(found.data), stored.segments, stored.maps, stored.options, stored.portion,
                                        stored.share, stored.features_are_shared},
                                       std::move(found.sightings),
                                       found.joins,
                                       found.is_settled,
                                       std::move(found.untied)};
    for (LocalMap<Dim>& map : result.data.maps) {
      for (FeatureIndex& feature : map.features) feature = names[feature];
    }
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
