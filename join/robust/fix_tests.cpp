// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/align/joined_map.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/robust/fix_tests.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/localmap/split.hpp>
#include <span>

namespace mapjoin {

template <int Dim>
std::optional<std::vector<PartTest>> fix_tests(Log<Dim> log, Engine engine, const std::stop_token& stop) {
  const SubmapGraph<Dim> graph = submap_graph_of(log, split(log, {SplitRule::kPoses, 1.0}), {});
  PartialMap<Dim> joined_map = joined_map_of(graph);
  set_to_values(log.initial, joined_map);
  JoiningSystem<Dim> system(joined_map, gauge_of(graph, joined_map), engine);
  system.linearise();
  if (system.factorise(0.0)) return std::nullopt;
  const Marginals marginals(system.equations());
  std::vector<bool> counts;
  for (PoseFactor<Dim>& fix : std::span(log.graph.pose_factors).subspan(log.edges().size())) {
    counts.push_back(fix.loss != Loss::dropped());
    fix.loss = {};  // tests are of the measurements as they are
  }
  LeaveOneOut<Dim> leave_one_out(system, system.equations(), marginals);
  const std::vector<std::size_t> factors = places_among(system.pose_factors(), log.pose_priors());
  std::vector<std::size_t> counting;
  for (std::size_t f = 0; f < counts.size(); ++f) {
    if (counts[f]) counting.push_back(factors[f]);
  }
  leave_one_out.solve_for_weak(counting, stop);
  std::vector<PartTest> tests;
  for (std::size_t f = 0; f < counts.size(); ++f) {
    tests.push_back(counts[f] ? leave_one_out.test({factors[f], 0, system.rows(factors[f])})
                              : leave_one_out.prediction(factors[f]));
  }
  return tests;
}

template std::optional<std::vector<PartTest>> fix_tests(Log<2>, Engine, const std::stop_token&);
template std::optional<std::vector<PartTest>> fix_tests(Log<3>, Engine, const std::stop_token&);

}  // namespace mapjoin
