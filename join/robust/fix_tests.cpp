// SPDX-License-Identifier: BSD-3-Clause
#include <functional>
#include <mapjoin/join/align/joined_map.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/robust/fix_tests.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/split.hpp>
#include <span>

namespace mapjoin {
namespace {

/// The numbers of a log's pose priors among the factors of a system, in which pose factors come first.
template <int Dim>
std::vector<std::size_t> factors_of_priors(const JoiningSystem<Dim>& system, const Log<Dim>& log) {
  const std::span<const PoseFactor<Dim>> priors = log.pose_priors();
  std::vector<std::size_t> factors(priors.size());
  for (std::size_t k = 0; k < system.pose_factors().size(); ++k) {
    const PoseFactor<Dim>* const factor = system.pose_factors()[k].observation;
    const auto prior = static_cast<std::size_t>(factor - priors.data());
    if (!std::less<>()(factor, priors.data()) && prior < priors.size()) factors[prior] = k;
  }
  return factors;
}

}  // namespace

template <int Dim>
std::optional<std::vector<PartTest>> fix_tests(Log<Dim> log, const std::vector<bool>& counts, Engine engine,
                                               const std::stop_token& stop) {
  const std::span<PoseFactor<Dim>> fixes = std::span(log.graph.pose_factors).subspan(log.edges().size());
  for (std::size_t f = 0; f < fixes.size(); ++f) fixes[f].loss = counts[f] ? Loss{} : Loss{0.0, 0.0};
  const SubmapGraph<Dim> graph = submap_graph_of(log, split(log, {SplitRule::kPoses, 1.0}), {});
  PartialMap<Dim> joined_map = joined_map_of(graph);
  set_to_values(log.initial, joined_map);
  JoiningSystem<Dim> system(joined_map, gauge_of(graph, joined_map), engine);
  system.linearise();
  if (system.factorise(0.0)) return std::nullopt;
  const Marginals marginals(system.equations());
  for (PoseFactor<Dim>& fix : fixes) fix.loss = {};  // tests are of the measurements as they are
  LeaveOneOut<Dim> leave_one_out(system, system.equations(), marginals);
  const std::vector<std::size_t> factors = factors_of_priors(system, log);
  std::vector<std::size_t> counting;
  for (std::size_t f = 0; f < fixes.size(); ++f) {
    if (counts[f]) counting.push_back(factors[f]);
  }
  leave_one_out.solve_for_weak(counting, stop);
  std::vector<PartTest> tests;
  for (std::size_t f = 0; f < fixes.size(); ++f) {
    tests.push_back(counts[f] ? leave_one_out.test({factors[f], 0, system.rows(factors[f])})
                              : leave_one_out.prediction(factors[f]));
  }
  return tests;
}

template std::optional<std::vector<PartTest>> fix_tests(Log<2>, const std::vector<bool>&, Engine, const std::stop_token&);
template std::optional<std::vector<PartTest>> fix_tests(Log<3>, const std::vector<bool>&, Engine, const std::stop_token&);

}  // namespace mapjoin
