// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What one run of the command did: what report and summary are made of.

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
  std::optional<PoseId> from;  ///< Nothing where it is the World.
  std::variant<PoseId, FeatureId> to;
  std::vector<std::size_t> lines = {};  ///< Of a prior that is a fix: of its file, those at this pose.
};

/// What was rejected, under the names of the input.
struct NamedRejected : NamedMisfit {
  WhyRejected why = WhyRejected::kContradicted;
};

/// Where the map stands on the earth, and by what.
struct GpsReport {
  struct Rejected {
    std::size_t line = 0;  ///< Of the file.
    PoseId pose;
    RejectedFix fix;
  };
  std::string file;
  Point<3> lever;
  GeographicFrame frame;      ///< Of the map.
  std::size_t fixes = 0;      ///< At or near a pose,
  std::int64_t left_out = 0;  ///< and not.
  std::vector<Rejected> rejected;
  std::multimap<PoseId, std::size_t> lines;  ///< Of the file, those of the other fixes, by pose.
};

struct RunReport {
  using Clock = std::chrono::steady_clock;

  RunReport(std::string command_name, const Options& given);

  /// The input.
  template <int Dim>
  void describe(const Log<Dim>& log);
  template <int Dim>
  void describe(const SubmapSet<Dim>& set);
  template <int Dim>
  void describe(const StoredMaps<Dim>& stored);
  /// What of the input, a log or a set of local maps, was left out.
  template <typename Input>
  void describe(const Input& input, const std::vector<Rejected>& left_out);
  /// Fixes that became priors of the log, and which of them are left out again.
  template <int Dim>
  void describe(const Log<Dim>& log, const AttachedFixes& attached, const std::vector<RejectedFix>& left_out);
  /// The result.
  template <int Dim>
  void describe(const RunResult<Dim>& result);

  /// Wall-clock seconds of each stage of the command, by its name, in their order.
  std::vector<std::pair<std::string, double>> stages() const;
  double total_seconds() const { return std::chrono::duration<double>(Clock::now() - start).count(); }

  Clock::time_point start = Clock::now();
  std::string command;
  std::string input;
  bool has_several_inputs = false;  ///< Or a store of several.
  int dimension = 0;
  Conventions conventions;
  Counts counts;
  bool has_stamps = false;
  RunOptions options;           ///< As asked for; once joined, with the schedule that found the map.
  bool has_local_maps = false;  ///< `figures` hold how they were built, or that they were given,
  bool was_damaged = false;     ///< What an interrupted build had left, which is begun afresh.
  bool is_resumed = false;      ///< The iterations in `figures` are only those since a build went on.
  bool is_joined = false;       ///< and what came of joining them.
  RunFigures figures;
  std::optional<AssociationOptions> association;  ///< Where features were associated:
  std::vector<AssociatedSighting> associations;
  bool association_is_settled = true;
  double association_seconds = 0.0;
  std::optional<RobustOptions> robust;  ///< Where wrong closures and observations were left out:
  std::vector<NamedRejected> rejected;
  double robust_seconds = 0.0;
  std::optional<GpsReport> gps;            ///< Where there are fixes.
  std::vector<PoseId> anchored;            ///< The gauge: anchored poses.
  std::vector<NamedMisfit> misfits;        ///< Of `figures.fit`.
  std::vector<PoseId> map_bases;           ///< Of `figures.maps`: the poses that they start from,
  std::vector<PoseId> map_ends;            ///< and those that they end at.
  std::optional<Estimate> covariances;     ///< Which estimate's were asked for, if any.
  std::optional<Deviations> deviations;    ///< Of its marginals, if any.
  std::optional<Consistency> consistency;  ///< With the truth, where that was given.
  std::optional<TruthErrors> errors;       ///< Likewise.
  double read_seconds = 0.0;
  double write_seconds = 0.0;
  std::vector<std::string> files;  ///< Written, in their order.
};

/// What `work` returns; its wall-clock time is added to `seconds`.
template <typename Work>
auto timed(double& seconds, Work&& work) {
  const Stopwatch watch(seconds);
  return work();
}

/// The largest memory the process has had so far (MB, 10⁶ bytes).
double peak_memory_mb();

}  // namespace mapjoin::apps
