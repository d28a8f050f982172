// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/join/study/basin.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/model/demand_valid.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <memory>
#include <mutex>
#include <utility>

namespace mapjoin {
namespace {

/// A problem to be solved in each way from each start.
struct Subject {
  Covariance covariance = Covariance::kOriginal;
  bool is_joining = false;
  std::optional<SplitOptions> split;
  std::function<Expected<RunFigures>(const RunOptions&)> solve;
};
using Subjects = std::vector<Subject>;

Expected<RunFigures> figures_of(auto result) {
  if (!result) return tl::unexpected(result.error());
  return RunFigures(*std::move(result));
}

template <int Dim>
Subject full_slam(const std::shared_ptr<const Log<Dim>>& log, const std::stop_token& stop) {
  return {log->conventions.covariance, false, std::nullopt,
          [log, stop](const RunOptions& options) { return figures_of(solve(*log, options, stop)); }};
}

/// Local maps are built once for all cells.
template <int Dim>
Expected<Subject> joining(const std::shared_ptr<const Log<Dim>>& log, Split parts, const std::optional<SplitOptions>& given,
                          const std::stop_token& stop) {
  auto built = build_local_maps(*log, parts, {}, stop);
  if (!built) return tl::unexpected(built.error());
  return Subject{log->conventions.covariance, true, given,
                 [log, parts = std::move(parts), maps = std::move(built->maps), stop](const RunOptions& options) {
                   return figures_of(run_from_maps(*log, parts, maps, options, stop));
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

RunOptions options_of(const BasinCell& cell, std::size_t run, const BasinOptions& options) {
  RunOptions solving;
  solving.schedule = Schedule::kBatch;
  solving.state = cell.formulation.state;
  solving.start = cell.start;
  solving.seed = BasinCell::seed_of(run);
  solving.solver.max_iterations = options.max_iterations;
  if (cell.method == BasinMethod::kGaussNewton) {
    solving.solver.method = Method::kGaussNewton;
  } else {
    solving.gradual = cell.formulation.state == JoinedState::kRelative;
  }
  return solving;
}

BasinRun outcome(const Expected<RunFigures>& figures) {
  BasinRun run;
  if (!figures) {
    run.failure = figures.error().message;
    return run;
  }
  if (std::isfinite(figures->chi2)) {
    run.chi2 = figures->chi2;
  } else {
    run.failure = "the map is not finite";
  }
  run.status = figures->join.status;
  run.iterations = figures->join.iterations;
  for (const PathPoint& point : figures->path) run.iterations += point.result.iterations;
  return run;
}

/// The cells of one subject, their runs yet to be made.
std::vector<BasinCell> cells_of(const Subject& subject, int seeds) {
  std::vector<BasinCell> cells;
  for (const JoinedState state : {JoinedState::kAbsolute, JoinedState::kRelative}) {
    for (const BasinMethod method : {BasinMethod::kGaussNewton, BasinMethod::kDefault}) {
      for (const Start start : kBasinStarts) {
        BasinCell cell{subject.covariance, {subject.is_joining, state}, subject.split, method, start, {}};
        cell.runs.resize(start == Start::kRandom ? static_cast<std::size_t>(seeds) : 1);
        cells.push_back(std::move(cell));
      }
    }
  }
  return cells;
}

/// All solves of an experiment: every run of every cell, and one per subject along the tree, for what is the optimum.
class Experiment {
 public:
  Experiment(const Subjects& subjects, const BasinOptions& options) : subjects_(subjects), options_(options) {
    for (const Subject& subject : subjects_) {
      tasks_.push_back({&subject, 0, 0, true});
      for (BasinCell& cell : cells_of(subject, options.seeds)) {
        for (std::size_t run = 0; run < cell.runs.size(); ++run) tasks_.push_back({&subject, cells_.size(), run, false});
        cells_.push_back(std::move(cell));
      }
    }
    tree_chi2_.resize(tasks_.size(), std::numeric_limits<double>::infinity());
  }

  void run(const std::stop_token& stop) {
    parallel_for(tasks_.size(), [&](std::size_t t) {
      if (stop.stop_requested()) return;
      const Task& task = tasks_[t];
      if (task.is_along_tree) {
        tree_chi2_[t] = outcome(task.subject->solve(RunOptions{})).chi2;
      } else {
        BasinCell& cell = cells_[task.cell];
        cell.runs[task.run] = outcome(task.subject->solve(options_of(cell, task.run, options_)));
      }
      report();
    });
  }

  Basin judged() && {
    Basin basin;
    for (const Subject& subject : subjects_) {
      if (!basin.covariances.empty() && basin.covariances.back() == subject.covariance) continue;
      basin.covariances.push_back(subject.covariance);
      basin.best_chi2.push_back(best_chi2(subject.covariance));
      judge(basin.covariances.back(), basin.best_chi2.back());
    }
    basin.cells = std::move(cells_);
    return basin;
  }

 private:
  struct Task {
    const Subject* subject;
    std::size_t cell;
    std::size_t run;
    bool is_along_tree;
  };

  double best_chi2(Covariance covariance) const {
    double best = std::numeric_limits<double>::infinity();
    for (std::size_t t = 0; t < tasks_.size(); ++t) {
      if (tasks_[t].subject->covariance == covariance) best = std::min(best, tree_chi2_[t]);
    }
    for (const BasinCell& cell : cells_) {
      for (const BasinRun& run : cell.runs) {
        if (cell.covariance == covariance) best = std::min(best, run.chi2);
      }
    }
    return best;
  }

  void judge(Covariance covariance, double best) {
    for (BasinCell& cell : cells_) {
      if (cell.covariance != covariance) continue;
      for (BasinRun& run : cell.runs) run.is_at_optimum = is_same_chi2(run.chi2, best);
    }
  }

  void report() {
    const std::lock_guard lock(mutex_);
    ++done_;
    if (options_.progress) options_.progress(done_, tasks_.size());
  }

  const Subjects& subjects_;
  const BasinOptions& options_;
  std::vector<BasinCell> cells_;
  std::vector<Task> tasks_;
  std::vector<double> tree_chi2_;  // per task that is along the tree
  std::mutex mutex_;
  std::size_t done_ = 0;
};

Expected<Basin> basin_of(const Subjects& subjects, const BasinOptions& options, const std::stop_token& stop) {
  Experiment experiment(subjects, options);
  experiment.run(stop);
  if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  Basin basin = std::move(experiment).judged();
  for (const double best : basin.best_chi2) {
    if (!std::isfinite(best)) return bad_input(basin.cells.front().runs.front().failure.value_or("no solve gives a map"));
  }
  return basin;
}

/// Full SLAM, then joining along each of the splits.
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
Expected<Basin> basin(const MapSet<Dim>& set, const BasinOptions& options, const std::stop_token& stop) {
  demand_valid(options);
  if (auto connected = check_connected(set); !connected) return tl::unexpected(connected.error());
  Subjects subjects;
  for (const auto& weighed : weighings(set)) {
    subjects.push_back({weighed->conventions.covariance, true, {}, [weighed, stop](const RunOptions& solving) {
                          return figures_of(run(*weighed, solving, stop));
                        }});
  }
  return basin_of(subjects, options, stop);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                              \
  template Expected<Basin> basin(const Log<Dim>&, const BasinOptions&, const std::stop_token&);               \
  template Expected<Basin> basin(const Log<Dim>&, const Split&, const BasinOptions&, const std::stop_token&); \
  template Expected<Basin> basin(const MapSet<Dim>&, const BasinOptions&, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
