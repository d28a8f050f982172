// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/run.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Steps of the join from which a map starts: truncated losses go on from there.
constexpr int kStartSteps = 1;

/// The scale at which the closures that count fit.
template <int Dim>
double scale_of_closures(const TruncatedJoin<Dim>& join) {
  return scale_of(join.counting_closure_tests(), kPoseDof<Dim>);
}

/// Drops the farthest observations and all closures beyond their gates; that of closures is found anew from those that remain,
/// until all are within it. True if any were dropped.
template <int Dim>
bool drop_misfits(TruncatedJoin<Dim>& join, Gates& gates) {
  bool any = join.drop_observations(gates.now().observations);
  while (join.drop_closures(gates.now().closures)) {
    any = true;
    gates.scale.closures = scale_of_closures(join);
  }
  return any;
}

/// The gates at which observations pass, and no closure does.
OfKinds gates_of_observations(const Gates& gates) {
  return {0.0, gates.now().observations};
}

}  // namespace

template <int Dim>
Expected<Values<Dim>> started_map(Log<Dim> log, Engine engine, const std::stop_token& stop) {
  const auto odometry = static_cast<std::ptrdiff_t>(log.odometry().size());
  auto& edges = log.graph.pose_factors;
  std::for_each(edges.begin(), edges.begin() + odometry, complete_weakly<Dim>);
  std::for_each(edges.begin() + odometry, edges.end(), [](PoseFactor<Dim>& edge) {
    if (measures_rotation(edge) && measures_position(edge)) complete_weakly(edge);  // otherwise the rest stays unmeasured
  });
  RunOptions options = without_verdict();
  options.schedule = Schedule::kAligned;
  options.solver.max_iterations = kStartSteps;
  options.solver.engine = engine;
  return solve(log, options, stop).map([](auto&& joined) {
    return Values<Dim>{std::move(joined.map.poses), std::move(joined.map.features)};
  });
}

template <int Dim>
Expected<void> settle(TruncatedJoin<Dim>& join, Gates& gates, const std::string& source, const std::stop_token& stop) {
  join.graduate(gates.now(), stop);
  bool are_readmitted = false;  // true once those dropped only because outliers bent the map are back
  bool is_dropping = false;     // the last round has dropped some, and a step is enough for this one
  for (bool is_first = true;; is_first = false) {
    if (is_dropping) {
      join.settle_by_a_step(stop);
    } else {
      join.settle(stop);
    }
    if (stop.stop_requested()) return interrupted("rejecting");
    if (!join.is_tested()) {
      return bad_input(source + ": the measurements that agree leave something free to move; without --robust " +
                       "the verdict names what is out of line");
    }
    gates.scale = {scale_of_closures(join), scale_of(join.counting_observation_tests(), Dim)};
    if (is_first && join.readmit(gates_of_observations(gates))) {
      join.graduate(gates.now(), stop);
    } else if (drop_misfits(join, gates)) {
      is_dropping = true;
    } else if (is_dropping) {
      is_dropping = false;
    } else if (!are_readmitted && join.readmit(gates.last.value_or(gates_of_observations(gates)))) {
      are_readmitted = true;
    } else {
      return {};
    }
  }
}

#define MAPJOIN_INSTANTIATE(Dim)                                                        \
  template Expected<Values<Dim>> started_map(Log<Dim>, Engine, const std::stop_token&); \
  template Expected<void> settle(TruncatedJoin<Dim>&, Gates&, const std::string&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
