// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/align/gauge.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The correspondences between the World (first frame) and a partial map (second frame).
template <int Dim>
Correspondences<Dim> world_correspondences(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& partial) {
  Correspondences<Dim> correspondences;
  for (const auto& fixed : graph.fixed) {
    if (const auto* pose = find_pose(partial, fixed.pose)) correspondences.add_pose(fixed.value, *pose);
  }
  for (const auto* prior : graph.priors.pose_factors) {
    const auto* pose = find_pose(partial, prior->target);
    if (!pose || !measures_position(*prior)) continue;
    const Pose<Dim> measured_end = measured_part(*prior, *pose);
    if (measures_rotation(*prior)) {
      correspondences.add_pose(prior->measured, measured_end);
    } else {
      correspondences.add_point(prior->measured.translation, measured_end.translation);
    }
  }
  for (const auto* prior : graph.priors.feature_factors) {
    const auto* feature = find_feature(partial, prior->target);
    if (feature && measures_position(*prior)) correspondences.add_point(prior->measured, *feature);
  }
  return correspondences;
}

/// The sum of squared distances between corresponding points under an alignment (m²).
template <int Dim>
double misfit(const Correspondences<Dim>& correspondences, const Pose<Dim>& alignment) {
  double sum = 0.0;
  for (std::size_t k = 0; k < correspondences.first_points.size(); ++k) {
    sum += (correspondences.first_points[k] - transform(alignment, correspondences.second_points[k])).squaredNorm();
  }
  return sum;
}

/// Places a map by the best of the candidates, or, if its positions lie on a line, as well as these tell: others may know the
/// roll.
template <int Dim>
void place_by(const Correspondences<Dim>& correspondences, PartialMap<Dim>& partial) {
  auto candidates = correspondences.candidates();
  if (candidates.empty()) {
    const auto aligned = least_turning_alignment(correspondences.second_points, correspondences.first_points);
    if (!aligned) return;
    candidates = {*aligned};
  }
  const auto best =
      cheapest_alignment<Dim>(candidates, [&](const Pose<Dim>& alignment) { return misfit(correspondences, alignment); });
  partial.state = moved(best, std::move(partial.state));
}

}  // namespace

template <int Dim>
void place_in_world(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin, PartialMap<Dim>& partial) {
  const Correspondences<Dim> correspondences = world_correspondences(graph, partial);
  if (!correspondences.first_points.empty()) return place_by(correspondences, partial);
  const Pose<Dim> frame = compose(origin, inverse(partial.state.poses.front()));
  partial.state = moved(frame, std::move(partial.state));
}

template <int Dim>
Gauge<Dim> gauge_of(const SubmapGraph<Dim>& graph, const PartialMap<Dim>& partial) {
  Gauge<Dim> gauge;
  for (const auto& fixed : graph.fixed) {
    if (holds(partial.poses, fixed.pose)) gauge.anchored.push_back(place_of(partial.poses, fixed.pose));
  }
  for (const auto* prior : graph.priors.pose_factors) {
    if (holds(partial.poses, prior->target)) gauge.priors.pose_factors.push_back(prior);
  }
  for (const auto* prior : graph.priors.feature_factors) {
    if (holds(partial.features, prior->target)) gauge.priors.feature_factors.push_back(prior);
  }
  if (gauge.anchored.empty() && gauge.priors.empty()) gauge.anchored = {0};
  return gauge;
}

template <int Dim>
void place_fixed_poses(const SubmapGraph<Dim>& graph, PartialMap<Dim>& partial) {
  for (const auto& fixed : graph.fixed) {
    if (holds(partial.poses, fixed.pose)) partial.state.poses[place_of(partial.poses, fixed.pose)] = fixed.value;
  }
}

template void place_in_world(const SubmapGraph<2>&, const Pose<2>&, PartialMap<2>&);
template void place_in_world(const SubmapGraph<3>&, const Pose<3>&, PartialMap<3>&);
template Gauge<2> gauge_of(const SubmapGraph<2>&, const PartialMap<2>&);
template Gauge<3> gauge_of(const SubmapGraph<3>&, const PartialMap<3>&);
template void place_fixed_poses(const SubmapGraph<2>&, PartialMap<2>&);
template void place_fixed_poses(const SubmapGraph<3>&, PartialMap<3>&);

}  // namespace mapjoin
