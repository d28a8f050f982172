// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/join/incremental/part.hpp>
#include <mapjoin/localmap/segment.hpp>

namespace mapjoin {
namespace {

/// The stretch at which a pose is known.
std::size_t stretch_of(const std::vector<Stretch>& stretches, Index pose) {
  const auto ends_at_or_after = [](const Stretch& stretch, Index p) { return stretch.end < p; };
  return static_cast<std::size_t>(std::lower_bound(stretches.begin(), stretches.end(), pose, ends_at_or_after) -
                                  stretches.begin());
}

template <int Dim>
std::vector<std::size_t> first_seen(const std::vector<Part<Dim>>& parts, std::size_t features) {
  std::vector<std::size_t> first(features, parts.size() - 1);
  for (std::size_t k = parts.size(); k-- > 0;) {
    if (parts[k].map) {
      for (const Index f : parts[k].map->features) first[static_cast<std::size_t>(f)] = k;
    }
    for (const auto& o : parts[k].feature_observations) first[static_cast<std::size_t>(o.target)] = k;
  }
  return first;
}

}  // namespace

template <int Dim>
std::vector<Part<Dim>> parts_of(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps) {
  std::vector<Part<Dim>> parts;
  auto map = maps.begin();
  for (const Stretch& stretch : split.stretches) {
    Part<Dim>& part = parts.emplace_back();
    part.stretch = stretch;
    if (stretch.is_map) {
      part.map = *map++;
      continue;
    }
    const auto odometry = odometry_of(log, stretch);
    const auto observations = observations_of(log, stretch);
    part.pose_observations.assign(odometry.begin(), odometry.end());
    part.feature_observations.assign(observations.begin(), observations.end());
  }
  const auto part_of = [&](Index pose) -> Part<Dim>& { return parts[stretch_of(split.stretches, pose)]; };
  for (const auto& o : log.closures()) part_of(std::max(o.base, o.target)).pose_observations.push_back(o);
  for (const auto& o : log.pose_priors()) part_of(o.target).pose_observations.push_back(o);
  for (const auto& fixed : log.graph.fixed) part_of(fixed.pose).fixed.push_back(fixed);
  const auto seen = first_seen(parts, log.features.size());
  for (const auto& o : log.feature_priors()) parts[seen[static_cast<std::size_t>(o.target)]].feature_observations.push_back(o);
  return parts;
}

template <int Dim>
Piece<Dim> composed(const Part<Dim>& part) {
  if (!part.stretch) return {};
  const auto is_inside = [&](Index pose) { return pose >= part.stretch->begin && pose <= part.stretch->end; };
  Network<Dim> alone;
  alone.stretches = {*part.stretch};
  if (part.map) alone.maps.push_back({*part.map, {}, {}, {}, {}});
  for (const auto& o : part.pose_observations) {
    if (is_inside(o.base) && is_inside(o.target)) alone.factors.pose_factors.push_back(&o);
  }
  for (const auto& o : part.feature_observations) {
    if (is_inside(o.base)) alone.factors.feature_factors.push_back(&o);
  }
  Piece<Dim> piece = Leaves<Dim>(alone).piece(0);
  piece.factors = {};
  return piece;
}

template <int Dim>
std::vector<LocalMap<Dim>> observations_as_maps(const Part<Dim>& part) {
  std::vector<LocalMap<Dim>> maps;
  for (const auto& o : part.pose_observations) maps.push_back({o.base, {o.target}, {}, {o.measured}, {}, o.information});
  for (const auto& o : part.feature_observations) maps.push_back({o.base, {}, {o.target}, {}, {o.measured}, o.information});
  return maps;
}

template <int Dim>
bool speaks_of_world(const Part<Dim>& part) {
  const auto is_of_world = [](const auto& o) { return o.base == kWorld; };
  return !part.fixed.empty() || std::any_of(part.pose_observations.begin(), part.pose_observations.end(), is_of_world) ||
         std::any_of(part.feature_observations.begin(), part.feature_observations.end(), is_of_world);
}

template <int Dim>
MapSet<Dim> set_of(const std::vector<const Part<Dim>*>& parts) {
  MapSet<Dim> set;
  Index poses = 0;
  Index features = 0;
  for (const Part<Dim>* part : parts) {
    if (part->stretch) set.stretches.push_back(*part->stretch);
    if (part->stretch) poses = std::max(poses, part->stretch->end + 1);
    if (part->map) set.graph.submaps.push_back(*part->map);
    if (part->map) {
      for (const Index f : part->map->features) features = std::max(features, f + 1);
    }
    for (const auto& o : part->pose_observations) set.graph.pose_factors.push_back(o);
    for (const auto& o : part->feature_observations) {
      set.graph.feature_factors.push_back(o);
      features = std::max(features, o.target + 1);
    }
    for (const auto& fixed : part->fixed) set.graph.fixed.push_back(fixed);
  }
  for (Index p = 0; p < poses; ++p) set.poses.push_back({0, static_cast<std::uint64_t>(p)});
  for (Index f = 0; f < features; ++f) set.features.push_back({static_cast<std::uint64_t>(f)});
  return set;
}

template <int Dim>
Network<Dim> network_of_parts(const MapSet<Dim>& set) {
  Network<Dim> network = network_of(set);
  network.is_joined.assign(set.poses.size(), false);
  const auto join = [&](Index pose) { network.is_joined[static_cast<std::size_t>(pose)] = true; };
  for (const auto& condensed : network.maps) {
    join(condensed.map.base);
    std::for_each(condensed.map.poses.begin(), condensed.map.poses.end(), join);
  }
  for (const Stretch& stretch : set.stretches) {
    for (Index pose = stretch.begin; !stretch.is_map && pose <= stretch.end; ++pose) join(pose);
  }
  return network;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                              \
  template std::vector<Part<Dim>> parts_of(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&); \
  template Piece<Dim> composed(const Part<Dim>&);                                                             \
  template std::vector<LocalMap<Dim>> observations_as_maps(const Part<Dim>&);                                 \
  template bool speaks_of_world(const Part<Dim>&);                                                            \
  template MapSet<Dim> set_of(const std::vector<const Part<Dim>*>&);                                          \
  template Network<Dim> network_of_parts(const MapSet<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
