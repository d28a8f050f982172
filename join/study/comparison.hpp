// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The comparison of joining with full SLAM on the same data (paper's VI): the cost of each case, and the distance of its map
// from the best one.

#include <cstdint>
#include <functional>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/formulation.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/measure/trajectory_error.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// One way of computing the map of a log.
struct ComparedCase {
  int poses_per_map = 1;  ///< Steps per local map; 1 is full SLAM, the join of one-step maps with nothing to polish.
  JoinedState state = JoinedState::kAbsolute;
  Schedule schedule = Schedule::kTree;
  bool gradual = false;  ///< True for the batch schedule by continuation.

  bool is_full_slam() const { return poses_per_map == 1; }
  Formulation formulation() const { return {!is_full_slam(), state}; }
  bool operator==(const ComparedCase&) const = default;
};

/// The schedule in words: "aligned", "tree", "sequential", "batch" or "gradual batch".
std::string schedule_in_words(const ComparedCase& way);
/// The case in words: "full SLAM, absolute, batch", "joining, relative, maps of 20 steps, gradual batch".
std::string to_string(const ComparedCase& way);

/// The cases to compare: full SLAM aligned, along the tree and by batch, then joining with each number of steps per map, by
/// these schedules and sequentially; each in the absolute and the relative state, in the latter also by gradual batch.
std::vector<ComparedCase> compared_cases(const std::vector<int>& poses_per_map);

/// The distance of a map from the truth, over the poses that are known of it.
struct TruthDistance {
  PoseErrorSummary absolute;            ///< Absolute trajectory error (ATE), after alignment.
  std::vector<PoseErrorSummary> spans;  ///< Relative pose errors by Comparison::spans.
};

/// The figures of an estimate of the whole log.
struct EstimateFigures {
  double chi2 = 0.0;
  MapDifference from_best;                   ///< Difference from the best map, without alignment.
  std::vector<PoseErrorSummary> best_spans;  ///< Differences of relative poses from the best map, by Comparison::spans.
  std::optional<TruthDistance> from_truth;
};

/// The figures of one case that do not depend on the dimension.
struct CaseFigures {
  ComparedCase way;
  std::string failure;  ///< Reason why there is no map, in a sentence, and then the only result; empty if there is a map.
  RunFigures run;
  Effort effort;
  EstimateFigures joined;     ///< The joined and recovered estimate; for full SLAM the same as `polished`.
  EstimateFigures polished;   ///< The final estimate.
  bool reaches_best = false;  ///< True if it converged to the least chi2 of all cases, to 1e-6 of it.

  bool has_map() const { return failure.empty(); }
  /// Iterations of the last join and of the path to it; joins before the last one are not counted.
  int join_iterations() const { return run.join.iterations + run.path_iterations(); }
  int polish_iterations() const { return run.polish ? run.polish->iterations : 0; }
};

struct ComparisonFigures {
  /// Spans of relative errors in steps within a session: 1, 2, 5, 10, …, as far as the longest goes.
  std::vector<std::size_t> spans;
  std::vector<CaseFigures> cases;
  std::size_t best = 0;  ///< The case whose map has the least chi2; the first of equals.
};

/// The maps of a case; empty if it gives none.
template <int Dim>
struct CaseMaps {
  GlobalMap<Dim> joined;
  GlobalMap<Dim> polished;
};

template <int Dim>
struct Comparison : ComparisonFigures {
  std::vector<CaseMaps<Dim>> maps;  ///< Maps by case.
};

template <int Dim>
struct ComparisonOptions {
  std::vector<ComparedCase> cases;
  MinimiseOptions solver;              ///< Solver of every case.
  const Truth<Dim>* truth = nullptr;   ///< Truth by the indices of the log, with at least two poses; null if unknown.
  std::size_t most_sequential = 2000;  ///< Largest number of maps joined one by one; a case with more is not tried.
  /// Called with the number of a case before it begins.
  std::function<void(std::size_t)> progress;
};

/// Runs the cases one after the other, so that each has the machine to itself. A case that gives no map says why; bad input if
/// none gives one, or the log is not connected; kInterrupted on `stop`. The result is the same for any number of threads,
/// except for Effort and RunFigures::seconds. Throws std::invalid_argument without cases, or with one of no steps per map.
template <int Dim>
Expected<Comparison<Dim>> compare(const Log<Dim>& log, const ComparisonOptions<Dim>& options, const std::stop_token& stop = {});

}  // namespace mapjoin
