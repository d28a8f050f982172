// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/simulate/random_stream.hpp>
#include <numbers>

namespace mapjoin {
namespace {

template <int Dim>
Eigen::AlignedBox<double, Dim> bounding_box(const Values<Dim>& state) {
  Eigen::AlignedBox<double, Dim> box;
  for (const auto& pose : state.poses) box.extend(pose.translation);
  for (const auto& feature : state.features) box.extend(feature);
  return box;
}

template <int Dim>
Point<Dim> random_point(const Eigen::AlignedBox<double, Dim>& box, RandomStream& random) {
  Point<Dim> point;
  for (int i = 0; i < Dim; ++i) point[i] = random.uniform(box.min()[i], box.max()[i]);
  return point;
}

template <int Dim>
Rotation<Dim> random_rotation(RandomStream& random) {
  if constexpr (Dim == 2) {
    return Rotation<2>(random.uniform(-std::numbers::pi, std::numbers::pi));
  } else {
    Eigen::Vector4d direction;  // direction of a normal vector: uniform on the sphere of unit quaternions
    for (int i = 0; i < 4; ++i) direction[i] = random.normal();
    return Rotation<3>(Eigen::Quaterniond(direction.normalized()));
  }
}

}  // namespace

template <int Dim>
PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>& graph) {
  PartialMap<Dim> joined_map;
  for (const PoseIndex p : indices(graph.is_joined)) {
    if (graph.is_joined[p]) joined_map.poses.push_back(p);
  }
  joined_map.factors = graph.factors;
  for (const auto& marginalised : graph.maps) joined_map.factors.submaps.push_back(&marginalised.map);

  Table<FeatureIndex, bool> is_seen(graph.feature_count, false);
  for (const auto* map : joined_map.factors.submaps) {
    for (const FeatureIndex feature : map->features) is_seen[feature] = true;
  }
  for (const auto* selection : {&graph.factors, &graph.priors}) {
    for (const auto* o : selection->feature_factors) is_seen[o->target] = true;
  }
  for (const FeatureIndex f : indices(is_seen)) {
    if (is_seen[f]) joined_map.features.push_back(f);
  }
  joined_map.state.poses.resize(joined_map.poses.size());
  joined_map.state.features.resize(joined_map.features.size(), Point<Dim>::Zero());
  return joined_map;
}

template <int Dim>
Values<Dim> composed_state(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& joined_map, const Pose<Dim>& origin,
                           JoinedPartialMaps<Dim> joined) {
  Values<Dim> state = joined_map.state;
  // Poses and features that partial maps share have their values in the first one.
  for (auto partial = joined.partials.rbegin(); partial != joined.partials.rend(); ++partial) {
    place_in_world(graph, origin, *partial);
    for (const PoseIndex p : indices(partial->poses)) {
      state.poses[place_of(joined_map.poses, partial->poses[p])] = partial->state.poses[p];
    }
    for (const FeatureIndex f : indices(partial->features)) {
      state.features[place_of(joined_map.features, partial->features[f])] = partial->state.features[f];
    }
  }
  return state;
}

template <int Dim>
Values<Dim> restricted(const Values<Dim>& state, const PartialMap<Dim>& partial) {
  Values<Dim> part;
  for (const PoseIndex p : partial.poses) part.poses.push_back(state.pose(p));
  for (const FeatureIndex f : partial.features) part.features.push_back(state.features[f]);
  return part;
}

template <int Dim>
void set_to_zero(PartialMap<Dim>& partial) {
  std::fill(partial.state.poses.begin() + 1, partial.state.poses.end(), Pose<Dim>{});
  std::fill(partial.state.features.begin(), partial.state.features.end(), Point<Dim>::Zero());
}

template <int Dim>
void set_to_random(std::uint64_t seed, PartialMap<Dim>& partial) {
  const auto box = bounding_box(partial.state);
  RandomStream random(seed, 0);
  for (auto pose = partial.state.poses.begin() + 1; pose != partial.state.poses.end(); ++pose) {
    pose->translation = random_point<Dim>(box, random);
    pose->rotation = random_rotation<Dim>(random);
  }
  for (auto& feature : partial.state.features) feature = random_point<Dim>(box, random);
}

template <int Dim>
void set_start(Start start, std::uint64_t seed, const Values<Dim>* values, PartialMap<Dim>& partial) {
  if (start == Start::kZero) set_to_zero(partial);
  if (start == Start::kRandom) set_to_random(seed, partial);
  if (start == Start::kFile) partial.state = restricted(*values, partial);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                         \
  template PartialMap<Dim> joined_map_of(const SubmapGraph<Dim>&);                                       \
  template Values<Dim> composed_state(const SubmapGraph<Dim>&, const PartialMap<Dim>&, const Pose<Dim>&, \
                                      JoinedPartialMaps<Dim>);                                           \
  template void set_to_zero(PartialMap<Dim>&);                                                           \
  template void set_to_random(std::uint64_t, PartialMap<Dim>&);                                          \
  template Values<Dim> restricted(const Values<Dim>&, const PartialMap<Dim>&);                           \
  template void set_start(Start, std::uint64_t, const Values<Dim>*, PartialMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
