// SPDX-License-Identifier: BSD-3-Clause
// mapjoin_limit: the work that no solver of a log, or of a set of local maps, can do without: reading the file and, once each,
// ordering and analysing the final information matrix, factorising it, and solving with it. The cost goes to standard output,
// as JSON.
#include <fmt/format.h>
#include <tbb/global_control.h>

#include <CLI/CLI.hpp>
#include <array>
#include <filesystem>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/align/start.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <nlohmann/json.hpp>
#include <variant>

namespace mapjoin {
namespace {

using AnyValues = std::variant<Values<2>, Values<3>>;

/// CPU seconds of each part; untimed work is not part of the limit.
struct Limit {
  double read = 0.0;
  double order = 0.0;
  double factorise = 0.0;
  double solve = 0.0;
  double chi2 = 0.0;
  std::size_t poses = 0;
  std::size_t features = 0;
};

template <typename F>
auto timed(double& seconds, F&& f) {
  const std::clock_t start = std::clock();
  auto result = f();
  seconds += static_cast<double>(std::clock() - start) / CLOCKS_PER_SEC;
  return result;
}

Expected<void> factorise_and_solve(NormalEquations& equations, Limit& limit) {
  if (timed(limit.factorise, [&] { return equations.factorise(0.0); })) return bad_input("the information matrix is singular");
  timed(limit.solve, [&] { return equations.solve(equations.gradient()); });
  return {};
}

/// The variables of full SLAM: poses, except anchored ones, then features.
template <int Dim>
class FullSlam {
 public:
  explicit FullSlam(const Log<Dim>& log) : log_(log), variables_(log.poses.size()) {
    for (const auto& fixed : log.graph.fixed) variables_[fixed.pose] = kConstant;
    if (log.graph.fixed.empty() && log.pose_priors().empty() && log.feature_priors().empty()) variables_.front() = kConstant;
    for (Variable& variable : variables_) {
      if (variable != kConstant) variable = std::exchange(first_feature_, first_feature_ + 1);
    }
  }

  NormalEquations equations() const {
    BlockPattern pattern;
    pattern.dofs.assign(first_feature_.position(), kPoseDof<Dim>);
    pattern.dofs.resize(pattern.dofs.size() + log_.features.size(), Dim);
    for (const auto& o : log_.graph.pose_factors) pattern.factors.push_back(std::array{pose(o.base), pose(o.target)});
    for (const auto& o : log_.graph.feature_factors) {
      pattern.factors.push_back(std::array{pose(o.base), first_feature_ + o.target.value});
    }
    return NormalEquations(std::move(pattern), Engine::kCholmod);
  }

  void linearise(const Values<Dim>& state, NormalEquations& equations) const {
    std::size_t factor = 0;
    const auto take = [&](const auto& o, const auto& target) {
      accumulate(mapjoin::linearise(o, state.pose(o.base), target), equations.sink(factor++));
    };
    for (const auto& o : log_.graph.pose_factors) take(o, state.pose(o.target));
    for (const auto& o : log_.graph.feature_factors) take(o, state.features[o.target]);
  }

 private:
  Variable pose(PoseIndex index) const { return index == kWorld ? kConstant : variables_[index]; }

  const Log<Dim>& log_;
  Table<PoseIndex, Variable> variables_;  // kConstant if anchored
  Variable first_feature_ = 0;
};

template <int Dim>
Expected<void> measure(const Log<Dim>& log, const Values<Dim>& state, Limit& limit) {
  const FullSlam<Dim> problem(log);
  NormalEquations equations = timed(limit.order, [&] { return problem.equations(); });
  problem.linearise(state, equations);
  limit.chi2 = log_chi2(log, state).total();
  return factorise_and_solve(equations, limit);
}

template <int Dim>
Expected<void> measure(const SubmapGraph<Dim>& graph, const Values<Dim>& state, Limit& limit) {
  PartialMap<Dim> partial = joined_map_of(graph);
  partial.state = restricted(state, partial);
  place_fixed_poses(graph, partial);
  const Gauge<Dim> gauge = gauge_of(graph, partial);
  JoiningSystem<Dim> problem = timed(limit.order, [&] { return JoiningSystem<Dim>(partial, gauge, Engine::kCholmod); });
  limit.chi2 = problem.linearise();
  return factorise_and_solve(problem.equations(), limit);
}

template <int Dim>
Expected<void> measure(const SubmapSet<Dim>& set, const Values<Dim>& state, Limit& limit) {
  return measure(submap_graph_of(set), state, limit);
}

template <int Dim>
Expected<void> measure(const StoredMaps<Dim>& stored, const Values<Dim>& state, Limit& limit) {
  return measure(submap_graph_of(stored.log, split_along(stored.log, stored.segments), stored.maps), state, limit);
}

/// The part of the data that names its poses and features.
const auto& names_of(const auto& data) {
  return data;
}
template <int Dim>
const Log<Dim>& names_of(const StoredMaps<Dim>& stored) {
  return stored.log;
}

template <int Dim, template <int> typename Data>
Expected<void> measure_at(const Data<Dim>& data, const AnyValues& any, Limit& limit) {
  const auto* state = std::get_if<Values<Dim>>(&any);
  limit.poses = names_of(data).poses.size();
  limit.features = names_of(data).features.size();
  if (!state || state->poses.size() != limit.poses || state->features.size() != limit.features) {
    return bad_input("the map is of another log");
  }
  return measure(data, *state, limit);
}

template <int Dim>
AnyValues state_of(const Log<Dim>& log) {
  return Values<Dim>{log.initial.poses, log.initial.features};
}

/// The values of all poses and features that a map holds.
Expected<AnyValues> read_state(const std::filesystem::path& path) {
  return open_log(path).map([](const AnyLog& any) { return std::visit([](const auto& log) { return state_of(log); }, any); });
}

Expected<Limit> limit_of(const std::filesystem::path& data, const AnyValues& state) {
  Limit limit;
  const auto take = [&](const auto& any) {
    return std::visit([&](const auto& known) { return measure_at(known, state, limit); }, any);
  };
  const auto measured = may_hold_maps(data) ? timed(limit.read, [&] { return open_maps(data); }).and_then(take)
                                            : timed(limit.read, [&] { return open_log(data); }).and_then(take);
  return measured.map([&] { return limit; });
}

void print(const Limit& limit) {
  const nlohmann::json json = {
      {"chi2", limit.chi2},
      {"poses", limit.poses},
      {"features", limit.features},
      {"seconds", {{"read", limit.read}, {"order", limit.order}, {"factorise", limit.factorise}, {"solve", limit.solve}}},
      {"cpu_seconds", limit.read + limit.order + limit.factorise + limit.solve},
      {"memory_mb", static_cast<double>(largest_resident_memory().value_or(0)) * 1e-6}};
  fmt::print("{}\n", json.dump());
}

}  // namespace
}  // namespace mapjoin

int main(int argc, char** argv) {
  std::filesystem::path data, map;
  CLI::App app("What no solver of a log, or of local maps, can do without.", "mapjoin_limit");
  app.add_option("data", data, "The log, or the local maps")->required();
  app.add_option("--map", map, "Its final map, as g2o")->required();
  CLI11_PARSE(app, argc, argv);
  const tbb::global_control one_thread(tbb::global_control::max_allowed_parallelism, 1);
  const auto state = mapjoin::read_state(map);
  const mapjoin::EffortMeter from_here;  // counts the largest memory from here on: that of the limit, and of its map
  const auto limit = state.and_then([&](const auto& known) { return mapjoin::limit_of(data, known); });
  if (limit) mapjoin::print(*limit);
  if (!limit) fmt::print(stderr, "mapjoin_limit: {}\n", limit.error().message);
  return limit ? 0 : 3;
}
