// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The record of one run of the command, from which report and summary are made.

#include <apps/certainty.hpp>
#include <apps/commands/options.hpp>
#include <apps/report/errors.hpp>
#include <chrono>
#include <cstdint>
#include <map>
#include <mapjoin/gps/fixes.hpp>
#include <mapjoin/io/store/store.hpp>
#include <mapjoin/join/covariances/consistency.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/counts.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {

/// A misfit under the names of its log.
struct NamedMisfit {
  Misfit misfit;
  std::optional<PoseId> from;  ///< Base pose; nullopt: the World.
  std::variant<PoseId, FeatureId> to;
  std::vector<std::size_t> lines = {};  ///< Lines of the fixes at this pose in their file, for a prior that is a fix.
};

/// A rejected measurement under the names of the input.
struct NamedRejected : NamedMisfit {
  WhyRejected why = WhyRejected::kContradicted;
};

/// The place of the map on the earth, and the fixes that determine it.
struct GpsReport {
  struct Rejected {
    std::size_t line = 0;  ///< Line of the file.
    PoseId pose;
    RejectedFix fix;
  };
  std::string file;
  Point<3> lever;
  GeographicFrame frame;      ///< Frame of the map.
  std::size_t fixes = 0;      ///< Number of fixes at or near a pose.
  std::int64_t left_out = 0;  ///< Number of fixes at no pose.
  std::vector<Rejected> rejected;
  std::multimap<PoseId, std::size_t> lines;  ///< Lines of the fixes that were not rejected, by pose.
};

struct RunReport {
  using Clock = std::chrono::steady_clock;

  RunReport(std::string command_name, const Options& given);

  /// Records the input.
  template <int Dim>
  void describe(const Log<Dim>& log);
  template <int Dim>
  void describe(const SubmapSet<Dim>& set);
  template <int Dim>
  void describe(const StoredMaps<Dim>& stored);
  /// Records what was left out of the input, a log or a set of local maps.
  template <typename Input>
  void describe(const Input& input, const std::vector<Rejected>& left_out);
  /// Records the fixes that became priors of the log, and those of them that are left out again.
  template <int Dim>
  void describe(const Log<Dim>& log, const AttachedFixes& attached, const std::vector<RejectedFix>& left_out);
  /// Records the result.
  template <int Dim>
  void describe(const RunResult<Dim>& result);

  /// Wall-clock seconds of each stage of the command, by its name, in their order.
  std::vector<std::pair<std::string, double>> stages() const;
  double total_seconds() const { return std::chrono::duration<double>(Clock::now() - start).count(); }

  Clock::time_point start = Clock::now();
  std::string command;
  std::string input;
  bool has_several_inputs = false;   ///< True for several inputs, or a store of several.
  bool features_are_shared = false;  ///< True for a store that says so of its inputs.
  int dimension = 0;
  Conventions conventions;
  Counts counts;
  bool has_stamps = false;
  RunOptions options;           ///< Options asked for; once joined, with the schedule that found the map.
  bool has_local_maps = false;  ///< True if `figures` hold how local maps were built or how many were given.
  bool was_damaged = false;     ///< True if the remains of an interrupted build were damaged, so that it began afresh.
  bool is_resumed = false;      ///< True if `figures` hold only the iterations since a build went on.
  bool is_joined = false;       ///< True if `figures` hold the result of joining.
  RunFigures figures;
  std::optional<AssociationOptions> association;  ///< Options of --associate, if given.
  std::vector<AssociatedSighting> associations;
  bool association_is_settled = true;
  double association_seconds = 0.0;
  std::optional<RobustOptions> robust;  ///< Options of --robust, if given.
  std::vector<NamedRejected> rejected;
  double robust_seconds = 0.0;
  std::optional<GpsReport> gps;            ///< Set if there are fixes.
  std::vector<PoseId> anchored;            ///< The gauge: anchored poses.
  std::vector<NamedMisfit> misfits;        ///< Misfits of `figures.fit`.
  std::vector<PoseId> map_bases;           ///< Poses that `figures.maps` start from.
  std::vector<PoseId> map_ends;            ///< Poses that `figures.maps` end at.
  std::optional<Estimate> covariances;     ///< Estimate of the covariances, if there are any.
  std::optional<Deviations> deviations;    ///< Medians of standard deviations, if there are marginals.
  std::optional<Consistency> consistency;  ///< Consistency with the truth, if given.
  std::optional<TruthErrors> errors;       ///< Errors against the truth, if given.
  bool truth_without_features = false;     ///< True if `--associate` named its features, or those of the map.
  std::size_t features_not_in_truth = 0;   ///< Number of features of the map that a truth with features does not have.
  double read_seconds = 0.0;
  double write_seconds = 0.0;
  std::vector<std::string> files;    ///< Files written, in their order.
  std::vector<std::string> renamed;  ///< What the numbering of a map in g2o changes, in words.
};

/// The result of `work`, whose wall-clock time is added to `seconds`.
template <typename Work>
auto timed(double& seconds, Work&& work) {
  const Stopwatch watch(seconds);
  return work();
}

/// The largest memory the process has had so far (MB, 10⁶ bytes).
double peak_memory_mb();

}  // namespace mapjoin::apps
