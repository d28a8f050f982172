// SPDX-License-Identifier: BSD-3-Clause
// The input of a command, and the work on it before the join: weights, association of features, outliers.
#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/report/associations.hpp>
#include <mapjoin/check/connectivity.hpp>
#include <mapjoin/io/formats/gps_csv.hpp>
#include <mapjoin/io/formats/pose_tables.hpp>
#include <mapjoin/io/open.hpp>
#include <mapjoin/join/association/associate.hpp>
#include <mapjoin/join/association/associate_in_doubt.hpp>
#include <mapjoin/join/association/feature_estimate.hpp>
#include <mapjoin/join/robust/fix_inliers.hpp>
#include <set>
#include <utility>

namespace mapjoin::apps {
namespace {

/// Refuses options that say how a log is read, for local maps; those that leave lines out may be for the truth.
void demand_none_of_logs(const std::string& input, const Options& options) {
  const ReadOptions& read = options.read;
  const bool has_truth = !options.truth.empty();
  const std::pair<const char*, bool> of_logs[] = {{"--from", read.from.has_value()},
                                                  {"--skip-unknown", !has_truth && read.skip_unknown},
                                                  {"--skip-self-edges", !has_truth && read.skip_self_edges},
                                                  {"--skip-undeclared", !has_truth && read.undeclared == Undeclared::kSkipped},
                                                  {"--identity-where-missing", !has_truth && read.identity_where_missing},
                                                  {"--stamps", !options.stamps.empty()},
                                                  {"--ids-are-nanoseconds", options.ids_are_nanoseconds}};
  for (const auto& [option, is_asked] : of_logs) {
    if (is_asked) fail(ErrorKind::kUsage, is_for_a_log(input, option));
  }
}

/// Refuses other weights than those that a store names: its maps are built with them.
template <int Dim>
void take_weights(const Options& options, StoredMaps<Dim>& stored) {
  const bool are_those = options.covariance == Covariance::kOriginal || options.covariance == stored.log.conventions.covariance;
  if (are_those && !options.read.repair_information && options.inflation == Inflation{}) return;
  refuse_weights_of_store();
}

/// Refuses to associate against names by which the maps of a store were built.
void demand_names(const std::string& input, const AssociationOptions& association) {
  if (association.names_hold) return;
  fail(ErrorKind::kUsage, input +
                              ": the local maps of a store were built by the ids of its log: --features own keeps these "
                              "within each of several stores; of one, --associate goes with `mapjoin build`");
}

/// Refuses to look for outliers in the local maps of a store.
[[noreturn]] void refuse_robust() {
  fail(ErrorKind::kUsage,
       "the local maps of a store are built already, with what may be wrong: --robust goes with `mapjoin run LOG`, whose "
       "inliers.g2o `mapjoin build` takes");
}

/// Refuses fixes at too few poses to hold the map: it could turn about them.
template <int Dim>
void demand_held(const Log<Dim>& log, const GpsFixes& fixes) {
  constexpr std::size_t kLeast = Dim == 2 ? 2 : 3;
  std::set<PoseIndex> poses;
  for (const PoseFactor<Dim>& prior : log.pose_priors()) poses.insert(prior.target);
  if (poses.size() >= kLeast) return;
  fail(
      ErrorKind::kBadInput,
      fmt::format("{}: has fixes at {} of {}, about which the map could turn: it takes fixes at {} different places at least{}",
                  fixes.source, plural(poses.size(), "pose"), log.source, kLeast, Dim == 2 ? "" : ", not on one line"));
}

template <int Dim>
Truth<Dim> truth_of(const TruthFile& file, const Log<Dim>& log) {
  return file.of(log);
}
template <int Dim>
Truth<Dim> truth_of(const TruthFile& file, const StoredMaps<Dim>& stored) {
  return file.of(stored.log);
}
template <int Dim>
Truth<Dim> truth_of(const TruthFile& file, const SubmapSet<Dim>& set) {
  return file.of<Dim>(set.poses, set.features, {});
}

/// Warns of ids that were taken for times where these are too near to each other for a drive.
template <int Dim>
void say_if_short(const Log<Dim>& log) {
  constexpr std::int64_t kShortestDrive = 1'000'000;  // (ns)
  if (log.stamps_ns.size() < 2) return;
  const auto [first, last] = std::ranges::minmax(log.stamps_ns);
  if (last - first >= kShortestDrive) return;
  say(log.source + ": with --ids-are-nanoseconds all of it takes less than a millisecond; leave that out unless ids are times");
}

template <typename Data>
bool knows(const TruthFile& file, const Data& data) {
  const auto truth = truth_of(file, data);
  const auto has_value = [](const auto& value) { return value.has_value(); };
  return std::ranges::any_of(truth.poses, has_value) || std::ranges::any_of(truth.features, has_value);
}

}  // namespace

AnyLog CommandRun::read_log() {
  AnyLog log = take_input(open_input());
  if (!options_.gps.empty()) std::visit([&](auto& any) { attach_gps(any); }, log);
  return log;
}

AnyLog CommandRun::open_input() {
  auto log = timed(run_report.read_seconds, [&] {
    return open_logs(inputs(), options_.read, options_.merging).and_then([&](AnyLog&& any) {
      return stamped(std::move(any)).map([&](AnyLog&& all) {
        if (truth_) std::visit([&](const auto& whole) { truth_->count_among(whole); }, all);
        return options_.parts == Parts::kLargest && !options_.association ? largest(all) : all;
      });
    });
  });
  if (!log && std::ranges::any_of(inputs(), may_hold_maps)) {
    fail(ErrorKind::kBadInput,
         fmt::format("{}: not a log, but perhaps local maps, which `mapjoin join` takes", run_report.input));
  }
  return std::move(log).value();
}

std::vector<std::filesystem::path> CommandRun::inputs() const {
  std::vector<std::filesystem::path> all = {options_.input};
  all.insert(all.end(), options_.further.begin(), options_.further.end());
  return all;
}

AnyLog CommandRun::largest(const AnyLog& any) {
  const auto take = [](const auto& log) -> AnyLog {
    auto parts = split_into_parts(log);
    auto largest = std::move(parts.front());
    for (auto part = parts.begin() + 1; part != parts.end(); ++part) {
      largest.skipped["poses of other parts"] += std::ssize(part->poses);
      if (!part->features.empty()) largest.skipped["features of other parts"] += std::ssize(part->features);
    }
    return largest;
  };
  return std::visit(take, any);
}

template <typename Data>
void CommandRun::demand_truth(const Data& data) const {
  if (!truth_ || knows(*truth_, data)) return;
  fail(ErrorKind::kUsage,
       fmt::format("{}: has no pose or feature of {}, by name, time or count; leave --truth out, and `mapjoin "
                   "error --max-time-difference S` measures the map where only times differ",
                   options_.truth.string(), run_report.input));
}

template <typename Data>
void CommandRun::settle_truth(const Data& data) {
  if (options_.parts != Parts::kAll) return demand_truth(data);
  if (!truth_ || knows(*truth_, data)) return;
  progress_.close();
  say(
      fmt::format("{}: has no pose or feature of the part in {}, by name, time or count; its map is not measured against it, "
                  "and `mapjoin error` measures it against another",
                  options_.truth.string(), options_.output.string()));
  truth_.reset();
  run_options_.covariances = false;
}

Expected<AnyLog> CommandRun::stamped(AnyLog any) const {
  const auto stamp = [&](auto& log) -> Expected<void> {
    if (options_.ids_are_nanoseconds) return take_ids_as_stamps(log).map([&] { say_if_short(log); });
    return options_.stamps.empty() ? Expected<void>() : read_stamps(options_.stamps, log);
  };
  return std::visit(stamp, any).map([&] { return std::move(any); });
}

AnyMaps CommandRun::read_maps() {
  demand_none_of_logs(run_report.input, options_);
  return take_input(
      timed(run_report.read_seconds, [&] { return open_several_maps(inputs(), options_.read, options_.merging); }).value());
}

template <typename Input>
Input CommandRun::take_input(Input input) {
  std::visit(
      [&](auto& any) {
        constexpr bool is_built = requires {
          any.log;
        };
        if (is_built && options_.robust) refuse_robust();
        take_weights(options_, any);
        run_report.describe(any);
        if (options_.association) associate_features(any);
        settle_truth(any);
        if constexpr (!is_built) {
          if (options_.robust) reject_outliers(any);
        }
      },
      input);
  check_interrupted();
  return input;
}

template <typename Data>
void CommandRun::associate_features(Data& data) {
  if constexpr (requires { data.log; }) demand_names(run_report.input, *options_.association);
  const Stopwatch watch(run_report.association_seconds);
  AssociationOptions association = *options_.association;
  if (progress_.is_shown()) {
    association.progress = [this](std::size_t joins) { progress_.show("associating, joins", joins, joins); };
  }
  auto associated = association_of(data, association).value();
  run_report.association = options_.association;
  run_report.associations = std::move(associated.sightings);
  run_report.association_is_settled = associated.is_settled;
  data = std::move(associated.data);
  run_report.describe(data);
  if (!associated.untied.empty()) settle_untied(associated.untied, data);
}

template <typename Data>
Expected<Associated<Data>> CommandRun::association_of(const Data& data, const AssociationOptions& association) const {
  if constexpr (!requires { data.log; }) {
    if (options_.robust) return associate_in_doubt(data, association, robust_options(), stop_);
  }
  return associate(data, association, stop_);
}

template <typename Data>
void CommandRun::settle_untied(const std::vector<UntiedParts>& untied, Data& data) {
  const std::string why = fmt::format("{}: {}", run_report.input, untied_in_words(untied));
  if constexpr (requires { data.observations(); }) {
    if (options_.parts != Parts::kLargest) fail(ErrorKind::kBadInput, why + "; --parts largest takes the largest part");
    data = std::get<Data>(largest(data));
    run_report.describe(data);
    const std::set<PoseId> taken(data.poses.begin(), data.poses.end());
    std::erase_if(run_report.associations, [&](const AssociatedSighting& seen) { return !taken.contains(seen.base); });
  } else {
    fail(ErrorKind::kBadInput, why);
  }
}

template <int Dim>
void CommandRun::attach_gps(Log<Dim>& log) {
  const GpsFixes fixes = timed(run_report.read_seconds, [&] { return read_gps_csv(options_.gps).value(); });
  const AttachedFixes attached = attach_fixes(fixes, options_.of_gps, log).value();
  demand_held(log, fixes);
  std::vector<RejectedFix> rejected;
  if (options_.robust) {
    const Stopwatch watch(run_report.robust_seconds);
    rejected = find_wrong_fixes(log, robust_options(), stop_).value();
  }
  run_report.describe(log, attached, rejected);
  log = without_fixes(log, rejected);
}

RobustOptions CommandRun::robust_options() const {
  RobustOptions robust = *options_.robust;
  robust.engine = options_.run.solver.engine;
  return robust;
}

template <typename Input>
void CommandRun::reject_outliers(Input& input) {
  if (tells_of_parts && !check_connected(input)) return;
  const Stopwatch watch(run_report.robust_seconds);
  if (progress_.is_shown()) progress_.show("rejecting", 0, 1);
  const auto fixed = input.graph.fixed;
  if (!options_.gps.empty()) hold_parts(input);  // fixes, which come later, tie them
  auto inliers = find_inliers(input, robust_options(), stop_).value();
  run_report.robust = options_.robust;
  run_report.describe(input, inliers.rejected);
  input = std::move(inliers.input);
  input.graph.fixed = fixed;
}

template AnyLog CommandRun::take_input(AnyLog);
template void CommandRun::demand_truth(const Log<2>&) const;
template void CommandRun::demand_truth(const Log<3>&) const;

}  // namespace mapjoin::apps
