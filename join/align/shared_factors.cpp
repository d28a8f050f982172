// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/align/shared_factors.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/lists.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// True if a partial map holds some, but not all, of a map's poses and features.
template <int Dim>
bool cuts(const PartialMap<Dim>& partial, const LocalMap<Dim>& map) {
  auto held = std::ranges::count_if(map.poses, [&](PoseIndex p) { return holds(partial.poses, p); });
  held += std::ranges::count_if(map.features, [&](FeatureIndex f) { return holds(partial.features, f); });
  if (holds(partial.poses, map.base)) ++held;
  return held > 0 && static_cast<std::size_t>(held) < 1 + map.poses.size() + map.features.size();
}

}  // namespace

template <int Dim>
SharedFactors<Dim>::SharedFactors(const PartialMap<Dim>& a, const PartialMap<Dim>& b,
                                  const std::vector<const PoseFactor<Dim>*>& closures)
    : a_(a), b_(b) {
  const auto is_cut_edge = [&](const auto* o) { return holds(a.poses, o->base) != holds(a.poses, o->target); };
  const auto is_between = [&](const auto* o) {
    return (holds(a.poses, o->base) && holds(b.poses, o->target)) || (holds(b.poses, o->base) && holds(a.poses, o->target));
  };
  for (const auto* o : evenly_chosen(closures, kMost, is_between)) {
    pose_factors_.push_back({o, end_of_pose(o->base), end_of_pose(o->target)});
  }
  for (const auto* o : evenly_chosen(b.factors.pose_factors, kMost, is_cut_edge)) {
    pose_factors_.push_back({o, end_of_pose(o->base), end_of_pose(o->target)});
  }
  const auto is_cut_observation = [&](const auto* o) { return holds(a.poses, o->base) != holds(a.features, o->target); };
  const auto cut_observations = evenly_chosen(b.factors.feature_factors, kMost, is_cut_observation);
  feature_factors_.reserve(cut_observations.size());
  for (const auto* o : cut_observations) feature_factors_.push_back({o, end_of_pose(o->base), end_of_feature(o->target)});
  for (const auto* map : evenly_chosen(b.factors.submaps, kMost, [&](const auto* m) { return cuts(a, *m); })) {
    PlacedMap placed{map, end_of_pose(map->base), {}, {}};
    for (const PoseIndex p : map->poses) placed.poses.push_back(end_of_pose(p));
    for (const FeatureIndex f : map->features) placed.features.push_back(end_of_feature(f));
    maps_.push_back(std::move(placed));
  }
}

template <int Dim>
typename SharedFactors<Dim>::template End<Pose<Dim>> SharedFactors<Dim>::end_of_pose(PoseIndex pose) const {
  if (const auto* in_a = find_pose(a_, pose)) return {*in_a, false};
  return {pose_in(b_, pose), true};
}

template <int Dim>
typename SharedFactors<Dim>::template End<Point<Dim>> SharedFactors<Dim>::end_of_feature(FeatureIndex feature) const {
  if (const auto* in_a = find_feature(a_, feature)) return {*in_a, false};
  return {feature_in(b_, feature), true};
}

template <int Dim>
double SharedFactors<Dim>::chi2(const Pose<Dim>& alignment) const {
  const auto pose = [&](const End<Pose<Dim>>& end) { return end.is_placed ? compose(alignment, end.value) : end.value; };
  const auto point = [&](const End<Point<Dim>>& end) { return end.is_placed ? transform(alignment, end.value) : end.value; };
  double chi2 = 0.0;
  for (const auto& [o, base, target] : pose_factors_) {
    chi2 += cost(*o, pose(base), pose(target));
  }
  for (const auto& [o, base, target] : feature_factors_) {
    // In the frame in which the base is given: moving a point is cheaper than moving a pose.
    const Point<Dim> beside_base = base.is_placed ? transform_into(alignment, point(target)) : point(target);
    chi2 += cost(*o, base.value, beside_base);
  }
  for (const auto& placed : maps_) {
    chi2 += cost(
        *placed.map, pose(placed.base), [&](std::size_t p) { return pose(placed.poses[p]); },
        [&](std::size_t f) { return point(placed.features[f]); });
  }
  return chi2;
}

template class SharedFactors<2>;
template class SharedFactors<3>;

}  // namespace mapjoin
