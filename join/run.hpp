// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The front door: from a log to a global map, or from local maps to one.

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

/// What a run is busy with.
enum class Stage : std::uint8_t { kBuild, kJoin, kRecover, kPolish, kCovariances };
constexpr auto enum_names(Stage) {
  return std::to_array<EnumName<Stage>>({{Stage::kBuild, "local maps"},
                                         {Stage::kJoin, "joins"},
                                         {Stage::kRecover, "recovering"},
                                         {Stage::kPolish, "polishing"},
                                         {Stage::kCovariances, "covariances"}});
}

/// The solver is that of every least-squares problem, local maps to polish.
struct RunOptions : JoinSettings {
  SplitOptions split;
  bool polish = true;             ///< Where local maps eliminated anything.
  bool verdict = true;            ///< Test whether the map fits: RunFigures::fit.
  std::size_t most_misfits = 20;  ///< That the fit names.
  bool covariances = false;       ///< Of the final estimate, too: RunResult::covariances.
  bool marginals = false;         ///< All of them, and the relations: RunResult::marginals, which take covariances.
  std::int64_t most_memory = 0;   ///< For covariances (bytes); 0: as much as the machine has.
  bool keep_recovered = false;    ///< RunResult::recovered.
  /// Called with a stage, what is done of it and what there is to do; from one thread at a time.
  std::function<void(Stage, std::size_t, std::size_t)> progress;

  /// Calls `progress` of a stage; nothing where there is none.
  std::function<void(std::size_t, std::size_t)> progress_of(Stage stage) const;
  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// The options for a map of which no verdict is wanted: one of many that are compared, say.
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

/// What a run says of itself, whatever the dimension.
struct RunFigures {
  std::size_t local_maps = 0;    ///< Segments that became maps.
  std::size_t raw_segments = 0;  ///< Segments that stayed observations.
  int poses_per_map = 0;         ///< As chosen; 0 where another rule than poses cut the log.
  std::int64_t build_iterations = 0;
  MinimiseResult join;
  std::vector<PathPoint> path;          ///< To the start of the join, where it was followed.
  Schedule schedule = Schedule::kTree;  ///< That the join was found by; of kAuto, the one of least chi2.
  bool is_settled = false;              ///< As of Join.
  double largest_rotation = 0.0;        ///< The most that the last solve of the join turned a pose (rad).
  std::int64_t join_dof = 0;
  std::vector<MapFit> maps;              ///< How each local map fits into the join.
  std::optional<double> recovered_chi2;  ///< Of the whole log before polishing.
  std::size_t unrecovered = 0;  ///< Segments whose interior did not converge when it was recovered; polishing cures it.
  std::optional<MinimiseResult> polish;
  double chi2 = 0.0;     ///< Of the final estimate: rᵀWr over the whole log, or over all maps where there is none.
  std::int64_t dof = 0;  ///< Measured rows less free variables.
  GoodnessOfFit fit;
  std::optional<Error> no_verdict;      ///< Why the fit is untested though a verdict was asked for: too little memory, say.
  std::optional<Error> no_covariances;  ///< Why there are none though they were asked for: something is free to move.
  RunSeconds seconds;
  std::int64_t joint_bytes = 0;  ///< What the last join keeps: the local maps' information matrices and its factor.

  int path_iterations() const;
  /// Whether the solves whose results are in the map converged: the polish, or else the join and the recovery.
  bool converged() const;
};

template <int Dim>
struct RunResult : RunFigures {
  GlobalMap<Dim> map;
  std::optional<Values<Dim>> recovered;                    ///< Of the whole log before polishing, where it was asked for.
  std::shared_ptr<const MapCovariances<Dim>> covariances;  ///< Where they were asked for; they own all they need.
  std::optional<MarginalCovariances<Dim>> marginals;
};

/// Splits the log, builds local maps, joins them, recovers what was eliminated, and polishes to the optimum of the whole log.
/// Where split and schedule are kAuto, no way of joining the maps was nearly linear, and polishing shows that they are crude,
/// it joins once without local maps, and gives the better map. Bad input: a log that falls apart, leaves something
/// undetermined, or has numbers so large that the map or its chi2 is not finite. kInterrupted on `stop`. Options that do not
/// validate are std::invalid_argument, here and below.
template <int Dim>
Expected<RunResult<Dim>> run(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop = {});

/// As run(), from local maps already built: `split` and `maps` as build_local_maps left them; bad input if they are not this
/// log's.
template <int Dim>
Expected<RunResult<Dim>> run_from_maps(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                       const RunOptions& options, const std::stop_token& stop = {});

/// Joins local maps of which nothing else is known: no recovery, no polish. The maps are taken out of the set.
template <int Dim>
Expected<RunResult<Dim>> run(SubmapSet<Dim> set, const RunOptions& options, const std::stop_token& stop = {});

/// Full SLAM: the join of one-step maps.
template <int Dim>
Expected<RunResult<Dim>> solve(const Log<Dim>& log, RunOptions options, const std::stop_token& stop = {});

}  // namespace mapjoin
