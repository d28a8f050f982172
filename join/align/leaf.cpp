// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/model/lists.hpp>
#include <numeric>

namespace mapjoin {
namespace {

/// Adds observations from poses of a partial map, and the features that are new where the first of them sees each.
template <int Dim>
void add_observations(const std::vector<const FeatureFactor<Dim>*>& observations, PartialMap<Dim>& partial) {
  const Table<FeatureIndex, FeatureIndex> before = partial.features;
  const Table<FeatureIndex, Point<Dim>> values = partial.state.features;
  for (const auto* o : observations) partial.features.push_back(o->target);
  make_distinct(partial.features);
  partial.state.features.resize(partial.features.size());
  Table<FeatureIndex, bool> is_placed(partial.features.size(), false);
  for (const FeatureIndex f : indices(before)) {
    const FeatureIndex place = place_in(partial, before[f]);
    partial.state.features[place] = values[f];
    is_placed[place] = true;
  }
  for (const auto* o : observations) {
    const FeatureIndex place = place_in(partial, o->target);
    if (!is_placed[place]) partial.state.features[place] = transform(pose_in(partial, o->base), o->measured);
    is_placed[place] = true;
  }
  append(partial.factors.feature_factors, observations);
}

}  // namespace

template <int Dim>
Leaves<Dim>::Leaves(const SubmapGraph<Dim>& graph)
    : graph_(graph),
      maps_(graph.segments.size(), nullptr),
      odometry_(graph.segments.size()),
      observations_(graph.segments.size()),
      joined_pose_count_(static_cast<std::size_t>(std::count(graph.is_joined.begin(), graph.is_joined.end(), true))) {
  auto map = graph.maps.begin();
  for (std::size_t k = 0; k < graph.segments.size(); ++k) {
    const Segment& segment = graph.segments[k];
    if (segment.is_map) maps_[k] = &(map++)->map;
    // A pose shared by two segments belongs to the later one.
    segment_of_.resize(static_cast<std::size_t>(segment.begin - graph.segments.front().begin), k - 1);
    segment_of_.resize(static_cast<std::size_t>(segment.end - graph.segments.front().begin) + 1, k);
  }
  for (const auto* o : graph.factors.pose_factors) {
    const auto [first, last] = segments_of(*o);
    if (first == last && !graph.segments[first].is_map) {
      odometry_[first].push_back(o);
    } else {
      closures_.push_back(o);
    }
  }
  for (const auto* o : graph.factors.feature_factors) observations_[segment_of(o->base)].push_back(o);
}

template <int Dim>
std::size_t Leaves<Dim>::segment_of(PoseIndex pose) const {
  const PoseIndex last(segment_of_.size() - 1);
  return segment_of_[std::clamp<PoseIndex>(PoseIndex(pose - graph_.segments.front().begin), 0, last)];
}

template <int Dim>
std::pair<std::size_t, std::size_t> Leaves<Dim>::segments_of(const PoseFactor<Dim>& observation) const {
  const auto [low, high] = std::minmax(observation.base, observation.target);
  const std::size_t first = segment_of(low);
  std::size_t last = segment_of(high);
  // The end pose of a segment belongs to that segment, too.
  if (last > first && graph_.segments[last - 1].end == high) --last;
  return {first, last};
}

template <int Dim>
PartialMap<Dim> Leaves<Dim>::partial(std::size_t segment) const {
  PartialMap<Dim> partial = maps_[segment] ? partial_of_map(*maps_[segment]) : partial_of_raw(segment);
  add_observations(observations_[segment], partial);
  return partial;
}

template <int Dim>
PartialMap<Dim> Leaves<Dim>::partial_of_map(const LocalMap<Dim>& map) const {
  PartialMap<Dim> partial;
  partial.factors.submaps.push_back(&map);
  partial.poses.push_back(map.base);
  partial.poses.insert(partial.poses.end(), map.poses.begin(), map.poses.end());
  partial.state.poses.emplace_back();
  partial.state.poses.insert(partial.state.poses.end(), map.pose_estimates.begin(), map.pose_estimates.end());
  partial.features = Table<FeatureIndex, FeatureIndex>(map.features);
  std::sort(partial.features.begin(), partial.features.end());
  partial.state.features.resize(partial.features.size());
  for (std::size_t f = 0; f < map.features.size(); ++f) {
    partial.state.features[place_of(partial.features, map.features[f])] = map.feature_estimates[f];
  }
  return partial;
}

template <int Dim>
PartialMap<Dim> Leaves<Dim>::partial_of_raw(std::size_t segment) const {
  const Segment& raw = graph_.segments[segment];
  PartialMap<Dim> partial;
  partial.poses.resize(static_cast<std::size_t>(raw.end - raw.begin) + 1);
  std::iota(partial.poses.begin(), partial.poses.end(), raw.begin);
  partial.state.poses.resize(partial.poses.size());
  partial.factors = {odometry_[segment], {}, {}};

  Table<PoseIndex, bool> known(partial.poses.size(), false);
  known[0] = true;
  for (const auto* o : partial.factors.pose_factors) {
    const PoseIndex base = place_of(partial.poses, o->base);
    const PoseIndex target = place_of(partial.poses, o->target);
    if (known[base] && !known[target]) partial.state.poses[target] = compose(partial.state.poses[base], o->measured);
    if (known[target] && !known[base]) partial.state.poses[base] = compose(partial.state.poses[target], inverse(o->measured));
    known[base] = known[target] = known[base] || known[target];
  }
  return partial;
}

template class Leaves<2>;
template class Leaves<3>;

}  // namespace mapjoin
