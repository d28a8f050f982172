// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/join/join.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/whole.hpp>
#include <mapjoin/join/world.hpp>
#include <mapjoin/measure/chi_squared.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <mapjoin/solve/free_directions.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
std::vector<MapFit> map_fits(const JointSystem<Dim>& system) {
  std::vector<MapFit> fits(system.maps().size());
  parallel_for(fits.size(), [&](std::size_t m) {
    const auto& placed = system.maps()[m];
    const LocalMap<Dim>& map = *placed.map;
    const Index end = map.poses.empty() ? map.base : map.poses.back();
    fits[m] = {map.base, end, map_chi2<Dim>(placed, system.estimate()), information_rank(map.information)};
  });
  return fits;
}

template <int Dim>
std::int64_t measured_rows(const Piece<Dim>& piece, const Gauge<Dim>& gauge, const std::vector<MapFit>& maps) {
  double rows = 0.0;
  for (const MapFit& map : maps) rows += static_cast<double>(map.rows);
  const auto add = [&](const auto& observations) {
    rows += parallel_sum(observations.size(), kObservationsPerPiece,
                         [&](std::size_t k) { return static_cast<double>(information_rank(observations[k]->information)); });
  };
  add(piece.pose_observations);
  add(gauge.pose_priors);
  add(piece.feature_observations);
  add(gauge.feature_priors);
  return static_cast<std::int64_t>(rows);
}

/// From the composed start to the one asked for.
template <int Dim>
void set_start(const JoinOptions<Dim>& options, Piece<Dim>& whole) {
  switch (options.start) {
    case Start::kComposed:
      return;
    case Start::kZero:
      return set_to_zero(whole);
    case Start::kRandom:
      return set_to_random(options.seed, whole);
    case Start::kFile:
      return set_to_values(*options.values, whole);
  }
}

/// The state of the whole network from the estimate of its joined part.
template <int Dim>
State<Dim> state_of(const Network<Dim>& network, const Piece<Dim>& whole, const State<Dim>& estimate) {
  State<Dim> state;
  state.poses.resize(network.pose_count);
  state.features.resize(network.feature_count, Point<Dim>::Zero());
  write_values(estimate, whole.poses, whole.features, state);
  for (const auto& condensed : network.maps) recover_private_features(condensed, state);
  return state;
}

tl::unexpected<Error> interrupted() {
  return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted while joining"});
}

/// The most that a pose is turned from one state to another (rad).
template <int Dim>
double most_turned(const State<Dim>& from, const State<Dim>& to) {
  double most = 0.0;
  for (std::size_t p = 0; p < to.poses.size(); ++p) {
    most = std::max(most, (from.poses[p].rotation.inverse() * to.poses[p].rotation).log().norm());
  }
  return most;
}

/// A solve that turns a pose further (rad) has left the part of space where the rotations, all that is not linear in a map,
/// are nearly so; it may have ended in a local minimum.
constexpr double kFarFromLinear = 1.0;
/// Maps that fit together less than this may be in a local minimum.
constexpr double kLeastProbability = 0.05;
/// Two joins whose chi2 differs by less than this share of it are the same.
constexpr double kSameChi2 = 1e-9;

/// Whether the chi2 of a join is such as its degrees of freedom make it.
template <int Dim>
bool fits(const Join<Dim>& join) {
  if (!std::isfinite(join.result.chi2)) return false;
  return join.dof() <= 0 || chi_squared_upper_tail(join.result.chi2, static_cast<double>(join.dof())) > kLeastProbability;
}

/// Whether a join need not be tried another way: its last solve converged from near by and, unless it is the first and
/// cheapest way, the maps fit. (Maps that are surer than right fit nowhere.)
template <int Dim>
bool is_trusted(const Join<Dim>& join) {
  const bool was_nearly_linear = join.result.status == MinimiseStatus::kConverged && join.turned < kFarFromLinear;
  return was_nearly_linear && (join.schedule == Schedule::kAligned || fits(join));
}

/// Directions that are looked at where a system is singular.
constexpr std::size_t kMostDirections = 60;

/// What the observations leave free to move, by name; `singular` is a variable of it.
template <int Dim>
std::string free_to_move(const JointSystem<Dim>& system, Index singular, const Piece<Dim>& whole,
                         const std::vector<PoseId>& pose_ids, const std::vector<FeatureId>& feature_ids) {
  const NormalEquations& equations = system.equations();
  std::vector<PlacedVariable<Dim>> variables;
  for (std::size_t p = 0; p < whole.poses.size(); ++p) {
    const Index v = system.pose_variable(static_cast<Index>(p));
    variables.push_back({to_string(pose_ids[static_cast<std::size_t>(whole.poses[p])]), system.estimate().poses[p],
                         v == kConstant ? -1 : equations.offset(v), true});
  }
  for (std::size_t f = 0; f < whole.features.size(); ++f) {
    variables.push_back({to_string(feature_ids[static_cast<std::size_t>(whole.features[f])]),
                         {system.estimate().features[f], {}},
                         equations.offset(system.feature_variable(static_cast<Index>(f))),
                         false});
  }
  const std::string found = free_directions(variables, equations.null_space(kMostDirections));
  const std::string& name = variables[static_cast<std::size_t>(system.place_of_variable(singular))].name;
  return found.empty() ? name + " cannot be determined" : found;
}

/// Joins by one schedule, not kAuto.
template <int Dim>
Expected<Join<Dim>> join_by(const Network<Dim>& network, const std::vector<PoseId>& pose_ids,
                            const std::vector<FeatureId>& feature_ids, const JoinOptions<Dim>& options,
                            const std::stop_token& stop) {
  ScheduleOptions schedule{options.schedule, options.state, ScheduleOptions::leading(options.schedule), options.progress};
  schedule.inner.engine = options.solver.engine;
  Piece<Dim> whole = whole_of(network);
  const Gauge<Dim> gauge = gauge_of(network, whole);
  JoinedPieces<Dim> pieces;
  std::optional<JoinProblem<Dim>> posed;  // its pattern, ordering and symbolic factor need no state
  parallel_invoke([&] { pieces = join_stretches(network, schedule, stop); },
                  [&] {
                    if (!stop.stop_requested()) posed.emplace(whole, gauge, options.solver.engine);
                  });
  if (stop.stop_requested()) return interrupted();

  whole.state = composed_state(network, whole, options.origin, std::move(pieces));
  set_start(options, whole);
  place_fixed_poses(network, whole);
  JoinProblem<Dim>& problem = *posed;
  problem.system().estimate() = whole.state;

  Join<Dim> result;
  result.schedule = options.schedule;
  if (options.gradual) {
    MinimiseOptions leading = ScheduleOptions::leading(options.schedule);
    leading.method = options.solver.method;
    result.path = lead_gradually(problem, whole, gauge, options.state, leading, stop);
  }
  const State<Dim> start = problem.estimate();
  result.result = minimise_join(problem, options.state, options.solver, stop);
  result.turned = most_turned(start, problem.estimate());
  if (result.result.status == MinimiseStatus::kInterrupted) return interrupted();
  if (result.result.status == MinimiseStatus::kSingular) {
    return bad_input(free_to_move(problem.system(), *result.result.singular, whole, pose_ids, feature_ids));
  }
  result.state = state_of(network, whole, problem.estimate());
  for (const Index place : gauge.held) result.held.push_back(whole.poses[static_cast<std::size_t>(place)]);
  result.maps = map_fits(problem.system());
  result.rows = measured_rows(whole, gauge, result.maps);
  result.poses = std::move(whole.poses);
  result.features = std::move(whole.features);
  result.system = std::make_unique<JointSystem<Dim>>(std::move(problem.system()));
  return result;
}

}  // namespace

double MapFit::probability() const {
  return chi_squared_upper_tail(chi2, static_cast<double>(rows));
}

template <int Dim>
Expected<Join<Dim>> join(const Network<Dim>& network, const std::vector<PoseId>& pose_ids,
                         const std::vector<FeatureId>& feature_ids, const JoinOptions<Dim>& options,
                         const std::stop_token& stop) {
  if (options.schedule != Schedule::kAuto) return join_by(network, pose_ids, feature_ids, options, stop);
  std::optional<Join<Dim>> best;
  for (const Schedule schedule : {Schedule::kAligned, Schedule::kTree, Schedule::kLeaning}) {
    JoinOptions<Dim> by = options;
    by.schedule = schedule;
    auto found = join_by(network, pose_ids, feature_ids, by, stop);
    if (stop.stop_requested()) return interrupted();
    if (!found && schedule == Schedule::kTree && !best) return found;
    if (!found || (best && best->result.chi2 < found->result.chi2 * (1.0 - kSameChi2))) continue;
    best = *std::move(found);
    if (is_trusted(*best)) break;
  }
  return *std::move(best);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                    \
  template Expected<Join<Dim>> join(const Network<Dim>&, const std::vector<PoseId>&, const std::vector<FeatureId>&, \
                                    const JoinOptions<Dim>&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
