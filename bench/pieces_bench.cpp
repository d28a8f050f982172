// SPDX-License-Identifier: BSD-3-Clause
// Times the pieces of a run on simulated worlds, by the number of poses, and covariances against a factorisation.
#include <benchmark/benchmark.h>

#include <chrono>
#include <cstdlib>
#include <mapjoin/io/g2o.hpp>
#include <mapjoin/io/local_map_set.hpp>
#include <mapjoin/io/open_log.hpp>
#include <mapjoin/join/run.hpp>
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
  for (auto _ : state) benchmark::DoNotOptimize(log_chi2(log, truth.poses, truth.features));
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

/// A whole run; the counters are the seconds of its stages, one run's mean.
template <int Dim>
void Run(benchmark::State& state) {
  const Log<Dim> log = world<Dim>(state).log;
  RunSeconds sum;
  for (auto _ : state) {
    const auto result = run(log, RunOptions{});
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

/// The covariances of all poses and features of a joined map, sim-35188 below the folder that MAPJOIN_DATA_DIR names; the
/// counter is their time in factorisations of the same system, made by turns.
void MarginalsOfTheLargeSimulation(benchmark::State& state) {
  using Clock = std::chrono::steady_clock;
  const char* folder = std::getenv("MAPJOIN_DATA_DIR");
  if (!folder) return state.SkipWithError("MAPJOIN_DATA_DIR is not set");
  const auto any = read_local_map_set(std::filesystem::path(folder) / "sim-35188/localmaps_mat.tar.gz");
  if (!any) return state.SkipWithError("cannot read sim-35188");
  const auto& set = std::get<MapSet<2>>(*any);
  const auto network = network_of(set);
  const auto joined = join(network, set.poses, set.features, JoinOptions<2>{});
  if (!joined) return state.SkipWithError("cannot join sim-35188");
  NormalEquations& equations = joined->system->equations();
  Clock::duration factorising{};
  Clock::duration marginalising{};
  for (auto _ : state) {
    const auto start = Clock::now();
    if (equations.factorise(0.0)) return state.SkipWithError("singular");
    const auto middle = Clock::now();
    const Marginals marginals(equations);
    for (Index v = 0; v < equations.variable_count(); ++v) benchmark::DoNotOptimize(marginals[v]);
    const auto end = Clock::now();
    factorising += middle - start;
    marginalising += end - middle;
    state.SetIterationTime(std::chrono::duration<double>(end - middle).count());
  }
  state.counters["factorisations"] = std::chrono::duration<double>(marginalising) / std::chrono::duration<double>(factorising);
}

constexpr auto kUnit = benchmark::kMillisecond;
BENCHMARK(Simulate<2>)->Arg(1'000)->Arg(100'000)->Unit(kUnit);
BENCHMARK(Simulate<3>)->Arg(1'000)->Arg(100'000)->Unit(kUnit);
BENCHMARK(EvaluateChi2<2>)->Arg(10'000)->Unit(kUnit);
BENCHMARK(EvaluateChi2<3>)->Arg(10'000)->Unit(kUnit);
BENCHMARK(ReadG2o<2>)->Arg(10'000)->Unit(kUnit);
BENCHMARK(ReadG2o<3>)->Arg(10'000)->Unit(kUnit);
BENCHMARK(Run<2>)->Arg(1'000)->Arg(10'000)->Unit(kUnit);
BENCHMARK(Run<3>)->Arg(1'000)->Unit(kUnit);
BENCHMARK(MarginalsOfTheLargeSimulation)->UseManualTime()->Unit(kUnit);

}  // namespace
}  // namespace mapjoin
