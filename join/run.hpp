// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The entry points: from a log to a global map, or from local maps to one.

#include <functional>
#include <mapjoin/join/covariances/map_covariances.hpp>
#include <mapjoin/join/fit/goodness_of_fit.hpp>
#include <mapjoin/join/join.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/split.hpp>
#include <mapjoin/model/error.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/local_map.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <mapjoin/model/values.hpp>
#include <memory>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

/// A stage of a run.
enum class Stage : std::uint8_t { kBuild, kJoin, kRecover, kPolish, kCovariances };
constexpr auto enum_names(Stage) {
  return std::to_array<EnumName<Stage>>({{Stage::kBuild, "local maps"},
                                         {Stage::kJoin, "joins"},
                                         {Stage::kRecover, "recovering"},
                                         {Stage::kPolish, "polishing"},
                                         {Stage::kCovariances, "covariances"}});
}

/// The options of a run. `solver` serves every least-squares problem, from local maps to the polish.
struct RunOptions : JoinSettings {
  SplitOptions split;
  bool polish = true;             ///< Refine to an optimum of the whole log, if there are local maps.
  bool verdict = true;            ///< Test whether the map fits: RunFigures::fit.
  std::size_t most_misfits = 20;  ///< Largest number of misfits that the fit names.
  bool covariances = false;       ///< Provide covariances of the final estimate: RunResult::covariances.
  bool marginals = false;         ///< Compute all marginals and relations: RunResult::marginals; implies `covariances`.
  std::int64_t most_memory = 0;   ///< Memory limit for covariances (bytes); 0: that of the machine.
  bool keep_recovered = false;    ///< Keep the estimate before polishing: RunResult::recovered.
  /// Called with a stage, and the number of its items done and to do; from one thread at a time.
  std::function<void(Stage, std::size_t, std::size_t)> progress;

  /// `progress` of one stage; null if `progress` is null.
  std::function<void(std::size_t, std::size_t)> progress_of(Stage stage) const;
  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// The options without a verdict, for one of many maps that are compared, say.
inline RunOptions without_verdict(RunOptions options = {}) {
  options.verdict = false;
  return options;
}

/// Wall-clock seconds of each stage.
struct RunSeconds {
  double build = 0.0;
  double join = 0.0;
  double recover = 0.0;
  double polish = 0.0;
  double verdict = 0.0;
  double covariances = 0.0;

  RunSeconds& operator+=(const RunSeconds& others);
};

/// The figures of a run that do not depend on the dimension.
struct RunFigures {
  std::size_t local_maps = 0;    ///< Segments that became maps.
  std::size_t raw_segments = 0;  ///< Segments that stayed observations.
  int poses_per_map = 0;         ///< Steps per map as chosen; 0 if the rule does not count poses.
  std::int64_t build_iterations = 0;
  JoinResult join;                       ///< Last solve of the join; `is_confirmed` is of the final map.
  std::vector<PathPoint> path;           ///< Path to the start of the join; empty if none was followed.
  std::vector<MapFit> maps;              ///< Fit of each local map in the join.
  std::optional<double> recovered_chi2;  ///< chi2 of the whole log before polishing; nullopt without a log.
  std::size_t unrecovered = 0;           ///< Segments whose interior did not converge in the recovery; polishing cures them.
  std::optional<MinimiseResult> polish;
  double chi2 = 0.0;     ///< chi2 of the final estimate, rᵀWr, over the whole log or, without one, over all maps.
  std::int64_t dof = 0;  ///< Measured rows less free variables.
  GoodnessOfFit fit;
  std::optional<Error> no_verdict;      ///< Reason why a verdict that was asked for is missing: too little memory, say.
  std::optional<Error> no_covariances;  ///< Reason why covariances that were asked for are missing: something is free to move.
  RunSeconds seconds;
  std::int64_t joint_bytes = 0;  ///< Memory of the last join (bytes): the local maps' information matrices and its factor.

  int path_iterations() const;
  /// True if the polish converged or, without one, the join and the recovery.
  bool converged() const;
};

template <int Dim>
struct RunResult : RunFigures {
  GlobalMap<Dim> map;
  std::optional<Values<Dim>> recovered;                    ///< Estimate before polishing; nullopt unless asked for.
  std::shared_ptr<const MapCovariances<Dim>> covariances;  ///< Covariances, which own all they need; null unless asked for.
  std::optional<MarginalCovariances<Dim>> marginals;
};

/// Splits the log, builds local maps, joins them, recovers the eliminated variables, and polishes to an optimum of the whole
/// log. If split and schedule are kAuto, no schedule settled the join, and polishing shows that the local maps are crude, it
/// joins once more without local maps and returns the better map. Bad input if check_invariants() finds a fault in the log, or
/// it is not connected, leaves a variable undetermined, or has numbers so large that the map or its chi2 is not finite;
/// kInterrupted on `stop`. Throws std::invalid_argument if the options do not validate.
template <int Dim>
Expected<RunResult<Dim>> run(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop = {});

/// Joins, recovers and polishes as run(), from local maps already built: `split` and `maps` are as build_local_maps left them.
/// Errors as run(), and bad input if they are not of this log.
template <int Dim>
Expected<RunResult<Dim>> run_from_maps(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                       const RunOptions& options, const std::stop_token& stop = {});

/// Joins local maps without their log: no recovery, no polish. Errors as run().
template <int Dim>
Expected<RunResult<Dim>> run(SubmapSet<Dim> set, const RunOptions& options, const std::stop_token& stop = {});

/// Solves full SLAM: the join of one-step maps. Errors as run().
template <int Dim>
Expected<RunResult<Dim>> solve(const Log<Dim>& log, RunOptions options, const std::stop_token& stop = {});

}  // namespace mapjoin
