// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
JoiningSystem<Dim>::JoiningSystem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, Engine engine,
                                  const std::vector<PoseOrFeature>& order)
    : JoiningSystem(partial, gauge, make_solver(engine), {}, order) {}

template <int Dim>
JoiningSystem<Dim>::JoiningSystem(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge, std::unique_ptr<SparseSolver> solver,
                                  const std::vector<PoseOrFeature>& border, const std::vector<PoseOrFeature>& order)
    : variables_(partial.state.poses.size(), partial.state.features.size(), gauge.anchored),
      estimate_(partial.state),
      equations_({}) {
  observe(partial, gauge);
  equations_ = make_equations(std::move(solver),
                              {.given = Table<Column, Variable>(variables_at(order)), .border = variables_at(border)});
}

template <int Dim>
void JoiningSystem<Dim>::observe(const PartialMap<Dim>& partial, const Gauge<Dim>& gauge) {
  pose_factors_.clear();
  feature_factors_.clear();
  maps_.clear();
  const auto pose_place = [&](PoseIndex pose) { return pose == kWorld ? kWorld : place_of(partial.poses, pose); };
  const auto feature_place = [&](FeatureIndex feature) { return place_of(partial.features, feature); };
  for (const auto* selection : {&partial.factors, &gauge.priors}) {
    for (const auto* o : selection->pose_factors) {
      pose_factors_.push_back({o, pose_place(o->base), pose_place(o->target)});
    }
    for (const auto* o : selection->feature_factors) {
      feature_factors_.push_back({o, pose_place(o->base), feature_place(o->target)});
    }
  }
  for (const auto* map : partial.factors.submaps) {
    PlacedMap placed{map, pose_place(map->base), {}, {}};
    for (const PoseIndex pose : map->poses) placed.poses.push_back(pose_place(pose));
    for (const FeatureIndex feature : map->features) placed.features.push_back(feature_place(feature));
    maps_.push_back(std::move(placed));
  }
  first_map_factor_ = pose_factors_.size() + feature_factors_.size();
}

template <int Dim>
typename JoiningSystem<Dim>::Source JoiningSystem<Dim>::source_of(std::size_t factor) const {
  if (factor < pose_factors_.size()) return {Source::kPoseFactor, factor};
  if (factor < first_map_factor_) return {Source::kFeatureFactor, factor - pose_factors_.size()};
  return {Source::kMap, factor - first_map_factor_};
}

template <int Dim>
Eigen::Index JoiningSystem<Dim>::rows(std::size_t factor) const {
  const auto [kind, place] = source_of(factor);
  if (kind == Source::kMap) return maps_[place].map->information.rows();
  return kind == Source::kPoseFactor ? kPoseDof<Dim> : Dim;
}

template <int Dim>
std::vector<Variable> JoiningSystem<Dim>::variables_at(const std::vector<PoseOrFeature>& places) const {
  std::vector<Variable> variables;
  for (const PoseOrFeature& placed : places) {
    if (const Variable at = variable(placed); at != kConstant) variables.push_back(at);
  }
  return variables;
}

template <int Dim>
NormalEquations JoiningSystem<Dim>::make_equations(std::unique_ptr<SparseSolver> solver, const Ordering& ordering) const {
  BlockPattern pattern{variables_.dofs(), {}};
  for (const auto& o : pose_factors_) pattern.factors.push_back(std::array{variable(o.base), variable(o.target)});
  for (const auto& o : feature_factors_) pattern.factors.push_back(std::array{variable(o.base), variable(o.target)});
  for (const auto& map : maps_) {
    std::vector<Variable> variables{variable(map.base)};
    for (const PoseIndex place : map.poses) variables.push_back(variable(place));
    for (const FeatureIndex place : map.features) variables.push_back(variable(place));
    pattern.factors.push_back(variables);
  }
  return NormalEquations(std::move(pattern), std::move(solver), ordering);
}

template <int Dim>
double JoiningSystem<Dim>::linearise() {
  equations_.set_zero();
  return equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
    return with_linear_factor(factor, [&](const auto& linear) { return accumulate(linear, sink); });
  });
}

template <int Dim>
void JoiningSystem<Dim>::add_curvature() {
  equations_.accumulate_factors([&](std::size_t factor, NormalEquations::Sink sink) {
    with_linear_factor(factor, [&](const auto& linear) { accumulate_curvature(linear, sink); });
    return 0.0;
  });
}

template <int Dim>
double JoiningSystem<Dim>::map_chi2(const PlacedMap& placed, const Values<Dim>& state) {
  return cost(
      *placed.map, state.pose(placed.base), [&](std::size_t p) { return state.pose(placed.poses[p]); },
      [&](std::size_t f) { return state.features[placed.features[f]]; });
}

template <int Dim>
double JoiningSystem<Dim>::chi2(const Values<Dim>& state) const {
  const double of_poses = parallel_sum(pose_factors_.size(), kObservationsPerPiece, [&](std::size_t k) {
    const auto& [o, base, target] = pose_factors_[k];
    return cost(*o, state.pose(base), state.pose(target));
  });
  const double of_features = parallel_sum(feature_factors_.size(), kObservationsPerPiece, [&](std::size_t k) {
    const auto& [o, base, target] = feature_factors_[k];
    return cost(*o, state.pose(base), state.features[target]);
  });
  return of_poses + of_features + parallel_sum(maps_.size(), 8, [&](std::size_t m) { return map_chi2(maps_[m], state); });
}

template <int Dim>
double JoiningSystem<Dim>::try_state(Values<Dim> candidate) {
  candidate_ = std::move(candidate);
  return chi2(candidate_);
}

template <int Dim>
double JoiningSystem<Dim>::rounding() const {
  double largest = 0.0;
  for (const Pose<Dim>& pose : estimate().poses) largest = std::max(largest, pose.translation.cwiseAbs().maxCoeff());
  for (const Point<Dim>& feature : estimate().features) largest = std::max(largest, feature.cwiseAbs().maxCoeff());
  return 16.0 * std::numeric_limits<double>::epsilon() * largest;
}

template class JoiningSystem<2>;
template class JoiningSystem<3>;

}  // namespace mapjoin
