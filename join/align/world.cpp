// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/align/placement.hpp>
#include <mapjoin/join/align/world.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
bool measures_position(const PoseObservation<Dim>& prior) {
  return (prior.information.diagonal().template head<Dim>().array() > 0.0).all();
}

template <int Dim>
bool measures_rotation(const PoseObservation<Dim>& prior) {
  return (prior.information.diagonal().template tail<kRotationDof<Dim>>().array() > 0.0).all();
}

/// What ties the World (first frame) to a piece (second frame).
template <int Dim>
Ties<Dim> world_ties(const Network<Dim>& network, const Piece<Dim>& piece) {
  Ties<Dim> ties;
  for (const auto& fixed : network.fixed) {
    if (const auto* pose = find_pose(piece, fixed.pose)) ties.add_pose(fixed.value, *pose);
  }
  for (const auto* prior : network.priors.pose_factors) {
    const auto* pose = find_pose(piece, prior->target);
    if (!pose || !measures_position(*prior)) continue;
    if (measures_rotation(*prior)) {
      ties.add_pose(prior->measured, *pose);
    } else {
      ties.add_point(prior->measured.translation, pose->translation);
    }
  }
  for (const auto* prior : network.priors.feature_factors) {
    if (const auto* feature = find_feature(piece, prior->target)) ties.add_point(prior->measured, *feature);
  }
  return ties;
}

/// Sum of squared distances of the tied points under a placement.
template <int Dim>
double misfit(const Ties<Dim>& ties, const Pose<Dim>& placement) {
  double sum = 0.0;
  for (std::size_t k = 0; k < ties.first_points.size(); ++k) {
    sum += (ties.first_points[k] - transform(placement, ties.second_points[k])).squaredNorm();
  }
  return sum;
}

template <int Dim>
void place_by(const Ties<Dim>& ties, Piece<Dim>& piece) {
  const auto candidates = ties.candidates();
  if (candidates.empty()) return;
  const auto best = cheapest_placement<Dim>(candidates, [&](const Pose<Dim>& placement) { return misfit(ties, placement); });
  piece.state = moved(best, std::move(piece.state));
}

}  // namespace

template <int Dim>
void place_in_world(const Network<Dim>& network, const Pose<Dim>& origin, Piece<Dim>& piece) {
  const Ties<Dim> ties = world_ties(network, piece);
  if (!ties.first_points.empty()) return place_by(ties, piece);
  const Pose<Dim> frame = compose(origin, inverse(piece.state.poses.front()));
  piece.state = moved(frame, std::move(piece.state));
}

template <int Dim>
Gauge<Dim> gauge_of(const Network<Dim>& network, const Piece<Dim>& piece) {
  Gauge<Dim> gauge;
  for (const auto& fixed : network.fixed) {
    if (holds(piece.poses, fixed.pose)) gauge.held.push_back(place_of(piece.poses, fixed.pose));
  }
  for (const auto* prior : network.priors.pose_factors) {
    if (holds(piece.poses, prior->target)) gauge.priors.pose_factors.push_back(prior);
  }
  for (const auto* prior : network.priors.feature_factors) {
    if (holds(piece.features, prior->target)) gauge.priors.feature_factors.push_back(prior);
  }
  if (gauge.held.empty() && gauge.priors.empty()) gauge.held = {0};
  return gauge;
}

template <int Dim>
void place_fixed_poses(const Network<Dim>& network, Piece<Dim>& piece) {
  for (const auto& fixed : network.fixed) {
    if (holds(piece.poses, fixed.pose))
      piece.state.poses[static_cast<std::size_t>(place_of(piece.poses, fixed.pose))] = fixed.value;
  }
}

template void place_in_world(const Network<2>&, const Pose<2>&, Piece<2>&);
template void place_in_world(const Network<3>&, const Pose<3>&, Piece<3>&);
template Gauge<2> gauge_of(const Network<2>&, const Piece<2>&);
template Gauge<3> gauge_of(const Network<3>&, const Piece<3>&);
template void place_fixed_poses(const Network<2>&, Piece<2>&);
template void place_fixed_poses(const Network<3>&, Piece<3>&);

}  // namespace mapjoin
