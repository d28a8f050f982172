// SPDX-License-Identifier: BSD-3-Clause
// Times the pieces of a run on simulated worlds, by the number of poses: reading, building, one step of the join and of the
// polish, covariances; and these against a factorisation.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/local_maps/local_map_set.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/relative_join.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/simulate/manhattan.hpp>
#include <mapjoin/solve/marginals.hpp>
#include <tests/support/temporary_folder.hpp>

namespace mapjoin {
namespace {

template <int Dim>
Simulation<Dim> world(const benchmark::State& state) {
  return simulate_manhattan<Dim>({.poses = state.range(0)});
}

template <int Dim>
void Simulate(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(world<Dim>(state));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

template <int Dim>
void EvaluateChi2(benchmark::State& state) {
  const auto [log, truth] = world<Dim>(state);
  for (auto _ : state) benchmark::DoNotOptimize(log_chi2(log, {truth.poses, truth.features}));
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

template <int Dim>
void ReadG2o(benchmark::State& state) {
  const testing::TemporaryFolder folder;
  const auto path = folder.path() / "log.g2o";
  if (!write_g2o(world<Dim>(state).log, path)) return state.SkipWithError("cannot write the log");
  for (auto _ : state) benchmark::DoNotOptimize(open_log(path));
  state.SetBytesProcessed(state.iterations() * static_cast<std::int64_t>(std::filesystem::file_size(path)));
}

/// A whole run; the counters are the seconds of its stages, as means per run.
template <int Dim>
void Run(benchmark::State& state) {
  const Log<Dim> log = world<Dim>(state).log;
  RunSeconds sum;
  for (auto _ : state) {
    const auto result = run(log, without_verdict());
    if (!result || !result->converged()) return state.SkipWithError("did not converge");
    sum.build += result->seconds.build;
    sum.join += result->seconds.join;
    sum.recover += result->seconds.recover;
    sum.polish += result->seconds.polish;
  }
  using Counter = benchmark::Counter;
  state.counters["build"] = Counter(sum.build, Counter::kAvgIterations);
  state.counters["join"] = Counter(sum.join, Counter::kAvgIterations);
  state.counters["recover"] = Counter(sum.recover, Counter::kAvgIterations);
  state.counters["polish"] = Counter(sum.polish, Counter::kAvgIterations);
}

template <int Dim>
void Build(benchmark::State& state) {
  const Log<Dim> log = world<Dim>(state).log;
  for (auto _ : state) {
    Split parts = split(log, SplitOptions{});
    if (!build_local_maps(log, parts, BuildOptions{})) return state.SkipWithError("cannot build");
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

/// A joined world; its members point to each other.
template <int Dim>
struct JoinedWorld {
  explicit JoinedWorld(const benchmark::State& state) : log(world<Dim>(state).log), parts(split(log, SplitOptions{})) {
    auto built = build_local_maps(log, parts, BuildOptions{});
    if (!built) return;
    graph = submap_graph_of(log, parts, std::move(built->maps));
    auto result = mapjoin::join(graph, log.poses, log.features, JoinOptions<Dim>{});
    if (result) join = *std::move(result);
  }
  JoinedWorld(const JoinedWorld&) = delete;
  JoinedWorld& operator=(const JoinedWorld&) = delete;

  Log<Dim> log;
  Split parts;
  SubmapGraph<Dim> graph;
  std::optional<Join<Dim>> join;
};

/// Gauss-Newton steps, each tried and then dropped.
template <typename Problem>
void step(benchmark::State& state, Problem& problem) {
  for (auto _ : state) {
    problem.linearise();
    if (problem.factorise(0.0)) return state.SkipWithError("singular");
    benchmark::DoNotOptimize(problem.try_step(problem.solve()));
  }
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

template <int Dim>
void JoinStep(benchmark::State& state) {
  JoinedWorld<Dim> world(state);
  if (!world.join) return state.SkipWithError("cannot join");
  JoiningSystem<Dim> problem(std::move(*world.join->system));
  step(state, problem);
}

template <int Dim>
void PolishStep(benchmark::State& state) {
  JoinedWorld<Dim> world(state);
  if (!world.join) return state.SkipWithError("cannot join");
  recover_interiors(world.log, world.parts, world.graph.is_local, MinimiseOptions{}, world.join->state);
  std::vector<SegmentView<Dim>> views;
  for (const Segment& segment : world.parts.segments) {
    if (segment.is_map) views.push_back(segment_view(world.log, world.parts, segment));
  }
  auto whole = restored(world.graph, views, *world.join, world.join->state);
  step(state, whole.system);
}

/// Covariances of all poses and features, in the map and relative, from an existing factor.
template <int Dim>
void Covariances(benchmark::State& state) {
  const Log<Dim> log = world<Dim>(state).log;
  RunOptions options = without_verdict();
  options.covariances = true;
  const auto result = run(log, options);
  if (!result || !result->covariances) return state.SkipWithError("no covariances");
  for (auto _ : state) benchmark::DoNotOptimize(result->covariances->marginals());
  state.SetItemsProcessed(state.iterations() * state.range(0));
}

/// The covariances of all poses and features of a joined map, sim-35188 below the folder that MAPJOIN_DATA_DIR names; the
/// counter is their time in units of a factorisation of the same system, made by turns.
void MarginalsOfTheLargeSimulation(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const char* folder = std::getenv("MAPJOIN_DATA_DIR");
  if (!folder) return state.SkipWithError("MAPJOIN_DATA_DIR is not set");
  const auto any = read_local_map_set(std::filesystem::path(folder) / "sim-35188/localmaps_mat.tar.gz");
  if (!any) return state.SkipWithError("cannot read sim-35188");
  const auto& set = std::get<SubmapSet<2>>(*any);
  const auto graph = submap_graph_of(set);
  const auto joined = join(graph, set.poses, set.features, JoinOptions<2>{});
  if (!joined) return state.SkipWithError("cannot join sim-35188");
  NormalEquations& equations = joined->system->equations();
  Clock::duration factorising{};
  Clock::duration marginalising{};
  for (auto _ : state) {
    const auto start = Clock::now();
    if (equations.factorise(0.0)) return state.SkipWithError("singular");
    const auto middle = Clock::now();
    const Marginals marginals(equations);
    for (const Variable v : equations.variables()) benchmark::DoNotOptimize(marginals[v]);
    const auto end = Clock::now();
    factorising += middle - start;
    marginalising += end - middle;
    state.SetIterationTime(std::chrono::duration<double>(end - middle).count());
  }
  state.counters["factorisations"] = std::chrono::duration<double>(marginalising) / std::chrono::duration<double>(factorising);
}

constexpr auto kUnit = benchmark::kMillisecond;
BENCHMARK(Simulate<2>)->Arg(1'000)->Arg(100'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Simulate<3>)->Arg(1'000)->Arg(100'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(EvaluateChi2<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(EvaluateChi2<3>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(ReadG2o<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(ReadG2o<3>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Build<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Build<3>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(JoinStep<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(JoinStep<3>)->Arg(1'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(PolishStep<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(PolishStep<3>)->Arg(1'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Covariances<2>)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Covariances<3>)->Arg(1'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Run<2>)->Arg(1'000)->Arg(10'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(Run<3>)->Arg(1'000)->MeasureProcessCPUTime()->Unit(kUnit);
BENCHMARK(MarginalsOfTheLargeSimulation)->UseManualTime()->Unit(kUnit);

}  // namespace
}  // namespace mapjoin
