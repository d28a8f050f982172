// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <map>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <memory>
#include <mutex>
#include <utility>

namespace mapjoin {
namespace {

/// A problem to be solved by each method from each start.
struct Subject {
  Covariance covariance = Covariance::kOriginal;
  bool is_joining = false;
  std::optional<SplitOptions> split;
  std::size_t maps = 0;  // number of local maps
  std::function<BasinRun(const RunOptions&)> solve;
};
using Subjects = std::vector<Subject>;

template <int Dim>
BasinRun outcome(const Expected<RunResult<Dim>>& result) {
  BasinRun run;
  if (!result) {
    run.failure = result.error().message;
    return run;
  }
  run.status = result->join.status;
  run.iterations = result->join.iterations + result->path_iterations();
  run.chi2 = result->chi2;
  return run;
}

template <int Dim>
Subject full_slam(const std::shared_ptr<const Log<Dim>>& log, const std::stop_token& stop) {
  return {log->conventions.covariance, false, std::nullopt, 0,
          [log, stop](const RunOptions& options) { return outcome(solve(*log, options, stop)); }};
}

/// The subject of joining, whose local maps are built once for all cells.
template <int Dim>
Expected<Subject> joining(const std::shared_ptr<const Log<Dim>>& log, Split parts, const std::optional<SplitOptions>& given,
                          const std::stop_token& stop) {
  auto built = build_local_maps(*log, parts, {}, stop);
  if (!built) return tl::unexpected(built.error());
  return Subject{log->conventions.covariance, true, given, built->maps.size(),
                 [log, parts = std::move(parts), maps = std::move(built->maps), stop](const RunOptions& options) {
                   return outcome(run_from_maps(*log, parts, maps, options, stop));
                 }};
}

/// The input, and the input with identity covariances unless it has them already.
template <typename Data>
std::vector<std::shared_ptr<const Data>> weighings(const Data& data) {
  std::vector<std::shared_ptr<const Data>> all = {std::make_shared<const Data>(data)};
  if (data.conventions.covariance == Covariance::kIdentity) return all;
  auto identity = std::make_shared<Data>(data);
  use_identity_covariance(*identity);
  all.push_back(std::move(identity));
  return all;
}

BasinRun solved(const Subject& subject, const BasinCell& cell, std::size_t run, const BasinOptions& options) {
  RunOptions solving = without_verdict();
  solving.schedule = Schedule::kBatch;
  solving.state = cell.formulation.state;
  solving.start = cell.start;
  solving.seed = BasinCell::seed_of(run);
  solving.solver.max_iterations = options.max_iterations;
  const bool is_default = cell.method == BasinMethod::kDefault;
  if (!is_default) solving.solver.method = Method::kGaussNewton;
  solving.gradual = is_default && cell.formulation.state == JoinedState::kRelative;
  return subject.solve(solving);
}

/// The cells of one subject, with runs yet to be made.
std::vector<BasinCell> cells_of(const Subject& subject, int seeds) {
  std::vector<BasinCell> cells;
  for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
    for (const BasinMethod method : {BasinMethod::kGaussNewton, BasinMethod::kDefault}) {
      for (const Start start : kBasinStarts) {
        const std::size_t runs = start == Start::kRandom ? static_cast<std::size_t>(seeds) : 1;
        cells.push_back({subject.covariance,
                         {subject.is_joining, state},
                         subject.split,
                         subject.maps,
                         method,
                         start,
                         std::vector<BasinRun>(runs)});
      }
    }
  }
  return cells;
}

/// Finds the best chi2 per covariance, of `others` (one per subject) and of all cells, and marks the runs that reach it.
void judge(const Subjects& subjects, const std::vector<BasinRun>& others, Basin& basin) {
  std::map<Covariance, double> best;
  const auto offer = [&](Covariance covariance, double chi2) {
    double& least = best.try_emplace(covariance, chi2).first->second;
    least = std::min(least, chi2);
  };
  for (std::size_t s = 0; s < subjects.size(); ++s) offer(subjects[s].covariance, others[s].chi2);
  for (const BasinCell& cell : basin.cells) {
    for (const BasinRun& run : cell.runs) offer(cell.covariance, run.chi2);
  }
  for (BasinCell& cell : basin.cells) {
    for (BasinRun& run : cell.runs) run.is_at_optimum = is_same_chi2(run.chi2, best.at(cell.covariance));
  }
  for (const auto& [covariance, chi2] : best) {
    basin.covariances.push_back(covariance);
    basin.best_chi2.push_back(chi2);
  }
}

/// Solves every run of every cell and, to find the optimum, each subject by the default schedule.
Expected<Basin> basin_of(const Subjects& subjects, const BasinOptions& options, const std::stop_token& stop) {
  Basin basin;
  std::vector<BasinRun> by_default(subjects.size());
  std::vector<std::function<void()>> solves;
  for (std::size_t s = 0; s < subjects.size(); ++s) {
    solves.emplace_back([&, s] { by_default[s] = subjects[s].solve(without_verdict()); });
    for (BasinCell& cell : cells_of(subjects[s], options.seeds)) {
      for (std::size_t run = 0; run < cell.runs.size(); ++run) {
        solves.emplace_back([&, s, c = basin.cells.size(), run] {
          basin.cells[c].runs[run] = solved(subjects[s], basin.cells[c], run, options);
        });
      }
      basin.cells.push_back(std::move(cell));
    }
  }
  std::mutex mutex;
  std::size_t done = 0;
  parallel_for(solves.size(), [&](std::size_t k) {
    if (stop.stop_requested()) return;
    solves[k]();
    const std::lock_guard lock(mutex);
    if (options.progress) options.progress(++done, solves.size());
  });
  if (stop.stop_requested()) return interrupted();
  judge(subjects, by_default, basin);
  for (std::size_t k = 0; k < basin.covariances.size(); ++k) {
    if (std::isfinite(basin.best_chi2[k])) continue;
    const auto cell = std::ranges::find(basin.cells, basin.covariances[k], &BasinCell::covariance);
    return bad_input(cell->runs.front().failure.value_or("no solve gives a map"));
  }
  return basin;
}

/// The subjects of a log: with each covariance full SLAM, then joining along each of the splits.
template <int Dim>
Expected<Subjects> subjects_of(const Log<Dim>& log, const std::vector<std::pair<Split, std::optional<SplitOptions>>>& splits,
                               const std::stop_token& stop) {
  Subjects subjects;
  for (const auto& weighed : weighings(log)) {
    subjects.push_back(full_slam<Dim>(weighed, stop));
    for (const auto& [parts, given] : splits) {
      auto subject = joining<Dim>(weighed, parts, given, stop);
      if (!subject) return tl::unexpected(subject.error());
      subjects.push_back(*std::move(subject));
    }
  }
  return subjects;
}

template <int Dim>
Expected<Basin> basin_along(const Log<Dim>& log, const std::vector<std::pair<Split, std::optional<SplitOptions>>>& splits,
                            const BasinOptions& options, const std::stop_token& stop) {
  return check_connected(log).and_then([&] { return subjects_of(log, splits, stop); }).and_then([&](const Subjects& subjects) {
    return basin_of(subjects, options, stop);
  });
}

}  // namespace

std::vector<std::string> BasinOptions::validate() const {
  std::vector<std::string> violations;
  for (const SplitOptions& split : splits) {
    for (auto& violation : split.validate()) violations.push_back(std::move(violation));
  }
  if (splits.empty()) violations.emplace_back("there is no split to join local maps of");
  if (seeds < 1) violations.emplace_back("there is no random start without a seed");
  if (max_iterations < 1) violations.emplace_back("a solve takes at least one iteration");
  return violations;
}

std::size_t BasinCell::hits() const {
  return static_cast<std::size_t>(std::count_if(runs.begin(), runs.end(), [](const auto& run) { return run.is_at_optimum; }));
}

template <int Dim>
Expected<Basin> basin(const Log<Dim>& log, const BasinOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto sound = check_invariants(log); !sound) return tl::unexpected(sound.error());
  std::vector<std::pair<Split, std::optional<SplitOptions>>> splits;
  for (const SplitOptions& given : options.splits) splits.emplace_back(split(log, given), given);
  return basin_along(log, splits, options, stop);
}

template <int Dim>
Expected<Basin> basin(const Log<Dim>& log, const Split& split, const BasinOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  return basin_along(log, {{split, std::nullopt}}, options, stop);
}

template <int Dim>
Expected<Basin> basin(const SubmapSet<Dim>& set, const BasinOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(set); !connected) return tl::unexpected(connected.error());
  Subjects subjects;
  for (const auto& weighed : weighings(set)) {
    subjects.push_back(
        {weighed->conventions.covariance, true, {}, weighed->graph.submaps.size(), [weighed, stop](const RunOptions& solving) {
           return outcome(run(*weighed, solving, stop));
         }});
  }
  return basin_of(subjects, options, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                              \
  template Expected<Basin> basin(const Log<Dim>&, const BasinOptions&, const std::stop_token&);               \
  template Expected<Basin> basin(const Log<Dim>&, const Split&, const BasinOptions&, const std::stop_token&); \
  template Expected<Basin> basin(const SubmapSet<Dim>&, const BasinOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
