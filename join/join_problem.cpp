// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <utility>

namespace mapjoin {
template <int Dim>
double map_chi2(const typename JoiningSystem<Dim>::PlacedMap& placed, const Values<Dim>& state) {
  return cost(
      *placed.map, state.pose(placed.base), [&](std::size_t p) { return state.pose(placed.poses[p]); },
      [&](std::size_t f) { return state.features[placed.features[f]]; });
}

template <int Dim>
double partial_map_chi2(const PartialMap<Dim>& partial) {
  double chi2 = 0.0;
  for (const auto* o : partial.factors.pose_factors) chi2 += cost(*o, pose_in(partial, o->base), pose_in(partial, o->target));
  for (const auto* o : partial.factors.feature_factors)
    chi2 += cost(*o, pose_in(partial, o->base), feature_in(partial, o->target));
  for (const auto* map : partial.factors.submaps) {
    chi2 += cost(
        *map, pose_in(partial, map->base), [&](std::size_t p) { return pose_in(partial, map->poses[p]); },
        [&](std::size_t f) { return feature_in(partial, map->features[f]); });
  }
  return chi2;
}

template <int Dim>
LinearMap<Dim> JoinProblem<Dim>::linear_map(std::size_t m) const {
  const auto& placed = system_.maps()[m];
  const Values<Dim>& state = system_.estimate();
  return mapjoin::linearise(
      *placed.map, state.pose(placed.base), [&](std::size_t p) { return state.pose(placed.poses[p]); },
      [&](std::size_t f) { return state.features[placed.features[f]]; });
}

template <int Dim>
double JoinProblem<Dim>::linearise() {
  return system_.linearise([&](std::size_t m, NormalEquations::Sink sink) { return accumulate(linear_map(m), sink); });
}

template <int Dim>
void JoinProblem<Dim>::add_curvature() {
  system_.add_curvature([&](std::size_t m, NormalEquations::Sink sink) { accumulate_curvature(linear_map(m), sink); });
}

template <int Dim>
double JoinProblem<Dim>::try_state(Values<Dim> candidate) {
  candidate_ = std::move(candidate);
  const auto& maps = system_.maps();
  return system_.observations_chi2(candidate_) +
         parallel_sum(maps.size(), 8, [&](std::size_t m) { return map_chi2<Dim>(maps[m], candidate_); });
}

template <int Dim>
double RelativeJoinProblem<Dim>::linearise() {
  is_damped_ = is_curved_ = is_weighed_ = false;
  const double chi2 = join_.linearise();
  relative_.linearise(join_.system());
  return chi2;
}

template <int Dim>
void RelativeJoinProblem<Dim>::add_curvature() {
  join_.add_curvature();
  is_curved_ = true;
}

template <int Dim>
const RelativeState<Dim>& RelativeJoinProblem<Dim>::metric() {
  if (!is_weighed_) relative_.weigh(join_.system());
  is_weighed_ = true;
  return relative_;
}

template <int Dim>
void RelativeJoinProblem<Dim>::undamp() {
  if (!std::exchange(is_damped_, false)) return;
  join_.linearise();
  if (is_curved_) join_.add_curvature();
}

template <int Dim>
double RelativeJoinProblem<Dim>::curvature(const Eigen::VectorXd& v) {
  undamp();
  return join_.curvature(v);
}

template <int Dim>
std::optional<Variable> RelativeJoinProblem<Dim>::factorise(double damping) {
  undamp();
  is_damped_ = damping > 0.0;
  if (is_damped_) metric().damp(join_.system(), damping);
  return join_.factorise(0.0);
}

template <int Dim>
MinimiseResult minimise_join(JoinProblem<Dim>& problem, JoinedState state, const MinimiseOptions& options,
                             const std::stop_token& stop) {
  if (state == JoinedState::kAbsolute) return minimise(problem, options, stop);
  RelativeJoinProblem<Dim> relative(problem);
  return minimise(relative, options, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)           \
  template class JoinProblem<Dim>;         \
  template class RelativeJoinProblem<Dim>; \
  template MinimiseResult minimise_join(JoinProblem<Dim>&, JoinedState, const MinimiseOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE
template double map_chi2<2>(const JoiningSystem<2>::PlacedMap&, const Values<2>&);
template double map_chi2<3>(const JoiningSystem<3>::PlacedMap&, const Values<3>&);
template double partial_map_chi2(const PartialMap<2>&);
template double partial_map_chi2(const PartialMap<3>&);

}  // namespace mapjoin
