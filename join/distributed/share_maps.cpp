// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/share_maps.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/model/renumber.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The map by the indices of the share; kBadInput if it has a feature that is not in the share.
template <int Dim>
Expected<LocalMap<Dim>> in_share(LocalMap<Dim> map, const LogShare<Dim>& share) {
  const auto is_in_share = [&](FeatureIndex feature) { return holds(share.features, feature); };
  if (!std::ranges::all_of(map.features, is_in_share)) return bad_input(share.log.source + ": a local map is not of this log");
  renumber(map, [&](auto index) { return place_in(share, index); });
  return map;
}

}  // namespace

template <int Dim>
Expected<ShareMaps<Dim>> built_maps(const LogShare<Dim>& share, const RunOptions& options) {
  Split parts = split(share.log, options.split, share.is_referenced);
  return build_local_maps(share.log, parts, {options.solver, nullptr}).map([&](LocalMaps<Dim> built) {
    return ShareMaps<Dim>{std::move(parts), std::move(built.maps), built.iterations};
  });
}

template <int Dim>
Expected<void> take_maps(const LogShare<Dim>& share, std::vector<std::optional<LocalMap<Dim>>> maps, ShareMaps<Dim>& into) {
  auto map = maps.begin();
  for (Segment& segment : into.split.segments) {
    if (!segment.is_map) continue;
    std::optional<LocalMap<Dim>>& stored = *map++;
    if (!stored) {
      make_raw(segment, into.split);
      continue;
    }
    auto own = in_share(*std::move(stored), share);
    if (!own) return tl::unexpected(own.error());
    into.maps.push_back(*std::move(own));
  }
  return check_local_maps(share.log, into.split, into.maps);
}

template Expected<void> take_maps(const LogShare<2>&, std::vector<std::optional<LocalMap<2>>>, ShareMaps<2>&);
template Expected<void> take_maps(const LogShare<3>&, std::vector<std::optional<LocalMap<3>>>, ShareMaps<3>&);
template Expected<ShareMaps<2>> built_maps(const LogShare<2>&, const RunOptions&);
template Expected<ShareMaps<3>> built_maps(const LogShare<3>&, const RunOptions&);

}  // namespace mapjoin::distributed
