// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Joining beside full SLAM on the same data (paper's VI): what each way to the map costs, and how far its map is from the best.

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

/// One way from a log to its map.
struct ComparedCase {
  int poses_per_map = 1;  ///< Steps of a local map. 1 is full SLAM: the join of one-step maps, with nothing to polish.
  JoinedState state = JoinedState::kAbsolute;
  Schedule schedule = Schedule::kTree;
  bool gradual = false;  ///< The batch schedule by continuation.

  bool is_full_slam() const { return poses_per_map == 1; }
  Formulation formulation() const { return {!is_full_slam(), state}; }
  bool operator==(const ComparedCase&) const = default;
};

/// "aligned", "tree", "sequential", "batch" or "gradual batch".
std::string schedule_in_words(const ComparedCase& way);
/// "full SLAM, absolute, batch", "joining, relative, maps of 20 steps, gradual batch".
std::string to_string(const ComparedCase& way);

/// Full SLAM, at once from the composed start and along the tree, only aligned or solved on the way, then joining with each
/// number of steps per map, along the tree likewise, map by map and at once; each in the absolute and in the relative state, in
/// the latter also gradually.
std::vector<ComparedCase> compared_cases(const std::vector<int>& poses_per_map);

/// How far it is from the truth, over the poses that are known of it.
struct TruthDistance {
  PoseErrorSummary absolute;            ///< After alignment: ATE.
  std::vector<PoseErrorSummary> spans;  ///< By Comparison::spans; a span counts known poses.
};

/// An estimate of the whole log.
struct EstimateFigures {
  double chi2 = 0.0;
  MapDifference from_best;                   ///< From the best map, as they stand,
  std::vector<PoseErrorSummary> best_spans;  ///< and in relative poses, by Comparison::spans.
  std::optional<TruthDistance> from_truth;
};

/// What came of one case, whatever the dimension.
struct CaseFigures {
  ComparedCase way;
  std::string failure;  ///< Why there is no map, in a sentence; empty where there is one, and else all that is known.
  RunFigures run;
  Effort effort;
  EstimateFigures joined;     ///< Joined and recovered; of full SLAM, as the next.
  EstimateFigures polished;   ///< The final one.
  bool reaches_best = false;  ///< It converged, to the least chi2 of all cases (to 1e-6 of it).

  bool has_map() const { return failure.empty(); }
  /// Of the last join, with those of the path to it. Joins below the last one are not counted.
  int join_iterations() const { return run.join.iterations + run.path_iterations(); }
  int polish_iterations() const { return run.polish ? run.polish->iterations : 0; }
};

struct ComparisonFigures {
  std::vector<std::size_t> spans;  ///< In steps: 1, 2, 5, 10, …, as far as the log goes.
  std::vector<CaseFigures> cases;
  std::size_t best = 0;  ///< The case whose map has the least chi2; the first of equals.
};

/// The maps of a case, empty where it gives none.
template <int Dim>
struct CaseMaps {
  GlobalMap<Dim> joined;
  GlobalMap<Dim> polished;
};

template <int Dim>
struct Comparison : ComparisonFigures {
  std::vector<CaseMaps<Dim>> maps;  ///< By case.
};

template <int Dim>
struct ComparisonOptions {
  std::vector<ComparedCase> cases;
  MinimiseOptions solver;              ///< Of every case.
  const Truth<Dim>* truth = nullptr;   ///< By the indices of the log; at least two poses of it.
  std::size_t most_sequential = 2000;  ///< Maps that are joined one by one; more take too long, and the case says so.
  /// Called with a case before it begins, by its number.
  std::function<void(std::size_t)> progress;
};

/// Works through the cases one after the other, so that each has the machine to itself. A case that gives no map says why; bad
/// input where none gives one, or the log falls apart; kInterrupted on `stop`. But for Effort and RunFigures::seconds, the same
/// for any number of threads. Throws std::invalid_argument without cases, or with one of no steps per map.
template <int Dim>
Expected<Comparison<Dim>> compare(const Log<Dim>& log, const ComparisonOptions<Dim>& options, const std::stop_token& stop = {});

}  // namespace mapjoin
