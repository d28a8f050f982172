// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/robust/robust_map.hpp>
#include <mapjoin/join/robust/weak_information.hpp>
#include <mapjoin/join/run.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Steps of the join from which a map starts: truncated losses go on from there.
constexpr int kStartSteps = 1;

/// Settles a map whose factors are all in doubt: drops those that do not fit, and readmits those that do.
template <int Dim>
class Settler {
 public:
  Settler(TruncatedJoin<Dim>& join, Gates& gates, const std::string& source, const std::stop_token& stop)
      : join_(join), gates_(gates), source_(source), stop_(stop) {}

  Expected<void> settle() {
    join_.graduate(gates_.now(), stop_);
    return settle_fully()
        .and_then([&] { return readmit_observations(); })
        .and_then([&] { return drop_all_misfits(); })
        .and_then([&] { return readmit_all(); });
  }

 private:
  /// Readmits the observations that graduation dropped only because outliers bent the map.
  Expected<void> readmit_observations() {
    if (!join_.readmit(gates_of_observations())) return {};
    join_.graduate(gates_.now(), stop_);
    return settle_fully();
  }

  /// Drops misfits until none are left at the optimum; after each drop but the last a step is enough.
  Expected<void> drop_all_misfits() {
    while (drop_misfits()) {
      do {
        join_.settle_by_a_step(stop_);
        if (auto tested = take_tests(); !tested) return tested;
      } while (drop_misfits());
      if (auto settled = settle_fully(); !settled) return settled;
    }
    return {};
  }

  /// Readmits, once, whatever fits the map of those that are left.
  Expected<void> readmit_all() {
    if (!join_.readmit(gates_.last.value_or(gates_of_observations()))) return {};
    return settle_fully().and_then([&] { return drop_all_misfits(); });
  }

  /// Drops the farthest observations, and closures beyond their gate: when all are tried again, the farthest one, as a wrong
  /// one makes right ones seem wrong, and else all, until those that remain are within the gate that is found anew from them.
  /// True if any were dropped.
  bool drop_misfits() {
    bool any = join_.drop_observations(gates_.now().observations);
    if (gates_.last) return join_.drop_farthest_closure(gates_.last->closures) || any;
    while (join_.drop_closures(gates_.now().closures)) {
      any = true;
      gates_.scale.closures = scale_of_closures();
    }
    return any;
  }

  Expected<void> settle_fully() {
    join_.settle(stop_);
    return take_tests();
  }

  /// Scales the gates by the tests of the last settling; an error if there are none.
  Expected<void> take_tests() {
    if (stop_.stop_requested()) return interrupted("rejecting");
    if (!join_.is_tested()) {
      return bad_input(source_ + ": the measurements that agree leave something free to move; without --robust " +
                       "the verdict names what is out of line");
    }
    gates_.scale = {scale_of_closures(), scale_of(join_.counting_observation_tests(), Dim)};
    return {};
  }

  /// The scale at which the closures that count fit.
  double scale_of_closures() const { return scale_of(join_.counting_closure_tests(), kPoseDof<Dim>); }
  /// The gates at which observations pass, and no closure does.
  OfKinds gates_of_observations() const { return {0.0, gates_.now().observations}; }

  TruncatedJoin<Dim>& join_;
  Gates& gates_;
  const std::string& source_;
  const std::stop_token& stop_;
};

}  // namespace

template <int Dim>
Expected<Values<Dim>> started_map(Log<Dim> log, Engine engine, const std::stop_token& stop) {
  const auto odometry = static_cast<std::ptrdiff_t>(log.odometry().size());
  auto& edges = log.graph.pose_factors;
  const PoseVector<Dim> weak = weak_information(log);
  std::for_each(edges.begin(), edges.begin() + odometry, [&](PoseFactor<Dim>& edge) { complete_weakly(edge, weak); });
  std::for_each(edges.begin() + odometry, edges.end(), [&](PoseFactor<Dim>& edge) {
    const bool measures_both = measures_rotation(edge) && measures_position(edge);
    if (measures_both) complete_weakly(edge, weak);  // otherwise the rest stays unmeasured
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
  return Settler<Dim>(join, gates, source, stop).settle();
}

#define MAPJOIN_INSTANTIATE(Dim)                                                        \
  template Expected<Values<Dim>> started_map(Log<Dim>, Engine, const std::stop_token&); \
  template Expected<void> settle(TruncatedJoin<Dim>&, Gates&, const std::string&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
