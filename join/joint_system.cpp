// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <mapjoin/join/joint_system.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
JointSystem<Dim>::JointSystem(const Piece<Dim>& piece, const Gauge<Dim>& gauge) : estimate_(piece.state), equations_({}, {}) {
  number_variables(gauge);
  place_observations(piece, gauge);
  equations_ = make_equations();
}

template <int Dim>
void JointSystem<Dim>::number_variables(const Gauge<Dim>& gauge) {
  pose_variables_.assign(estimate_.poses.size(), 0);
  for (const Index place : gauge.held) pose_variables_[static_cast<std::size_t>(place)] = kConstant;
  for (std::size_t place = 0; place < pose_variables_.size(); ++place) {
    if (pose_variables_[place] == kConstant) continue;
    pose_variables_[place] = static_cast<Index>(places_.size());
    places_.push_back(static_cast<Index>(place));
  }
  first_feature_variable_ = static_cast<Index>(places_.size());
  for (std::size_t f = 0; f < estimate_.features.size(); ++f) {
    places_.push_back(static_cast<Index>(estimate_.poses.size() + f));
  }
}

template <int Dim>
void JointSystem<Dim>::place_observations(const Piece<Dim>& piece, const Gauge<Dim>& gauge) {
  pose_observations_.clear();
  feature_observations_.clear();
  maps_.clear();
  const auto pose_place = [&](Index pose) { return pose == kWorld ? kWorld : place_of(piece.poses, pose); };
  const auto feature_place = [&](Index feature) { return place_of(piece.features, feature); };
  for (const auto* list : {&piece.pose_observations, &gauge.pose_priors}) {
    for (const auto* o : *list) pose_observations_.push_back({o, pose_place(o->base), pose_place(o->target)});
  }
  for (const auto* list : {&piece.feature_observations, &gauge.feature_priors}) {
    for (const auto* o : *list) feature_observations_.push_back({o, pose_place(o->base), feature_place(o->target)});
  }
  for (const auto* map : piece.maps) {
    PlacedMap placed{map, pose_place(map->base), {}, {}};
    for (const Index pose : map->poses) placed.poses.push_back(pose_place(pose));
    for (const Index feature : map->features) placed.features.push_back(feature_place(feature));
    maps_.push_back(std::move(placed));
  }
  first_map_clique_ = pose_observations_.size() + feature_observations_.size();
}

template <int Dim>
typename JointSystem<Dim>::Source JointSystem<Dim>::source_of(std::size_t clique) const {
  if (clique < pose_observations_.size()) return {Source::kPoseObservation, clique};
  if (clique < first_map_clique_) return {Source::kFeatureObservation, clique - pose_observations_.size()};
  return {Source::kMap, clique - first_map_clique_};
}

template <int Dim>
NormalEquations JointSystem<Dim>::make_equations() const {
  std::vector<int> dofs(static_cast<std::size_t>(first_feature_variable_), kPoseDof<Dim>);
  dofs.resize(places_.size(), Dim);
  Cliques cliques;
  for (const auto& o : pose_observations_) cliques.push_back(std::array{pose_variable(o.base), pose_variable(o.target)});
  for (const auto& o : feature_observations_) cliques.push_back(std::array{pose_variable(o.base), feature_variable(o.target)});
  for (const auto& map : maps_) {
    std::vector<Index> slots{pose_variable(map.base)};
    for (const Index place : map.poses) slots.push_back(pose_variable(place));
    for (const Index place : map.features) slots.push_back(feature_variable(place));
    cliques.push_back(slots);
  }
  return {std::move(dofs), std::move(cliques)};
}

template <int Dim>
double JointSystem<Dim>::linearise_observations() {
  equations_.set_zero();
  double chi2 = 0.0;
  std::size_t clique = 0;
  for (const auto& [o, base, target] : pose_observations_) {
    const auto linear = linearise<Dim>(o->measured, estimate_.pose(base), estimate_.pose(target));
    chi2 += accumulate(weighted(linear, o->information, o->loss), equations_.sink(clique++));
  }
  for (const auto& [o, base, target] : feature_observations_) {
    const auto linear = linearise<Dim>(o->measured, estimate_.pose(base), estimate_.feature(target));
    chi2 += accumulate(weighted(linear, o->information, o->loss), equations_.sink(clique++));
  }
  return chi2;
}

template <int Dim>
double JointSystem<Dim>::observations_chi2(const State<Dim>& state) const {
  double chi2 = 0.0;
  for (const auto& [o, base, target] : pose_observations_) {
    const PoseVector<Dim> r = residual<Dim>(o->measured, state.pose(base), state.pose(target));
    chi2 += r.dot(o->information * r);
  }
  for (const auto& [o, base, target] : feature_observations_) {
    const Point<Dim> r = residual<Dim>(o->measured, state.pose(base), state.feature(target));
    chi2 += r.dot(o->information * r);
  }
  return chi2;
}

template <int Dim>
State<Dim> JointSystem<Dim>::retracted(const Eigen::VectorXd& step) const {
  State<Dim> moved = estimate_;
  for (std::size_t place = 0; place < moved.poses.size(); ++place) {
    const Index variable = pose_variables_[place];
    if (variable == kConstant) continue;
    moved.poses[place] = retract<Dim>(moved.poses[place], step.segment<kPoseDof<Dim>>(equations_.offset(variable)));
  }
  const Eigen::Index first = equations_.offset(first_feature_variable_);
  for (std::size_t f = 0; f < moved.features.size(); ++f) {
    moved.features[f] += step.segment<Dim>(first + static_cast<Eigen::Index>(f) * Dim);
  }
  return moved;
}

template <int Dim>
StepSize JointSystem<Dim>::step_size(const Eigen::VectorXd& step) const {
  StepSize size;
  const auto count = static_cast<Index>(places_.size());
  for (Index v = 0; v < count; ++v) {
    const Eigen::Index entry = equations_.offset(v);
    size.metres = std::max(size.metres, step.segment<Dim>(entry).norm());
    if (v >= first_feature_variable_) continue;
    size.radians = std::max(size.radians, step.segment<kRotationDof<Dim>>(entry + Dim).norm());
  }
  return size;
}

template class JointSystem<2>;
template class JointSystem<3>;

}  // namespace mapjoin
