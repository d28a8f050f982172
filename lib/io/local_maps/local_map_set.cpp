// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/io/files/archive.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/local_maps/named_local_map.hpp>

namespace mapjoin {
namespace {

template <int Dim>
using NamedMaps = std::vector<NamedLocalMap<Dim>>;

/// The features' names in ascending order.
template <int Dim>
FeatureIds all_features(const NamedMaps<Dim>& maps) {
  FeatureIds all;
  for (const auto& map : maps) all.insert(all.end(), map.features.begin(), map.features.end());
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  return all;
}

/// Sorts the maps; their numbers must be 1, 2, ...
template <int Dim>
Expected<void> put_in_order(NamedMaps<Dim>& maps, const std::string& source) {
  std::sort(maps.begin(), maps.end(), [](const auto& a, const auto& b) { return a.number < b.number; });
  std::int64_t expected = 1;
  for (std::size_t i = 0; i < maps.size(); ++i, ++expected) {
    if (maps[i].number == expected) continue;
    if (maps[i].number > expected) return bad_input(fmt::format("{}: map {} is missing", source, expected));
    return bad_input(fmt::format("{}: map {} is there twice: {} and {}", source, maps[i].number, maps[i - 1].path.string(),
                                 maps[i].path.string()));
  }
  return {};
}

template <int Dim>
Expected<AnySubmapSet> assemble(NamedMaps<Dim>&& maps, const std::string& source, const MatrixRepairs& repairs) {
  if (auto ok = put_in_order(maps, source); !ok) return tl::unexpected(ok.error());
  SubmapSet<Dim> set;
  set.source = source;
  set.conventions.repairs = repairs;
  set.features = all_features(maps);
  set.poses.push_back(PoseId{0, 0});
  for (NamedLocalMap<Dim>& named : maps) {
    LocalMap<Dim>& map = set.graph.submaps.emplace_back(std::move(named.map));
    map.base = PoseIndex(set.poses.size() - 1);
    if (named.moves) {
      set.poses.push_back(PoseId{0, static_cast<std::uint64_t>(named.number)});
      map.poses.push_back(map.base + 1);
    }
    for (const FeatureId id : named.features) map.features.emplace_back(*find_ascending(set.features, id));
    set.segments.push_back({map.base, PoseIndex(set.poses.size() - 1), true});
  }
  return set;
}

}  // namespace

Expected<AnySubmapSet> read_local_map_set(const std::filesystem::path& folder_or_archive, const ReadOptions& options) {
  const std::string source = folder_or_archive.string();
  InformationCheck check(options.repair_information);
  NamedMaps<2> plane;
  NamedMaps<3> space;
  const auto take = [&](LocalMapFile&& file) -> Expected<void> {
    const auto dim = dimension(file);
    if (!dim) return tl::unexpected(dim.error());
    if (*dim == 2) return named_local_map<2>(std::move(file), check).map([&](auto map) { plane.push_back(std::move(map)); });
    return named_local_map<3>(std::move(file), check).map([&](auto map) { space.push_back(std::move(map)); });
  };
  const auto visited = visit_files(
      folder_or_archive, [](const std::string& name) { return local_map_number(name).has_value(); },
      [&](const std::filesystem::path& path, std::string_view bytes) { return parse_local_map(path, bytes).and_then(take); });
  if (!visited) return tl::unexpected(visited.error());
  if (plane.empty() && space.empty()) {
    return bad_input(fmt::format("{}: holds no localmap_<k>.mat or localmap_<k>.txt", source));
  }
  if (!plane.empty() && !space.empty()) {
    return bad_input(fmt::format("{}: {} is a map of the plane, but {} of space", source, plane.front().path.string(),
                                 space.front().path.string()));
  }
  return plane.empty() ? assemble(std::move(space), source, check.repairs())
                       : assemble(std::move(plane), source, check.repairs());
}

}  // namespace mapjoin
