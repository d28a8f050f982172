// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/certainty.hpp>
#include <apps/commands/command_run.hpp>
#include <apps/report/associations.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <cmath>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/io/formats/map_text.hpp>
#include <mapjoin/io/formats/mat_log.hpp>
#include <mapjoin/io/g2o/g2o.hpp>
#include <mapjoin/io/g2o/numbering.hpp>
#include <mapjoin/join/association/frames/name_fit.hpp>
#include <utility>

namespace mapjoin::apps {
namespace {

std::string why_not_converged(const RunReport& run_report) {
  const RunFigures& figures = run_report.figures;
  const MinimiseResult& last = figures.polish ? *figures.polish : figures.join;
  std::string why =
      fmt::format("the poses inside {} were not recovered to convergence", plural(figures.unrecovered, "local map"));
  if (last.status != MinimiseStatus::kConverged) {
    why = fmt::format("the {} did not converge ({} at iteration {})", figures.polish ? "polish" : "join",
                      to_string(last.status), last.iterations);
  }
  return run_report.files.empty() ? why : why + "; the result is written all the same";
}

std::string why_not_certified(const RunReport& run_report) {
  const std::string why = run_report.input + ": " + run_report.figures.no_covariances->message;
  return run_report.files.empty() ? why : why + "; the map is written without them";
}

std::string why_not_trusted(const RunReport& run_report) {
  const std::string why = run_report.input + ": " + verdict_in_words(run_report);
  return run_report.files.empty() ? why : why + "; the map is written all the same";
}

/// Says of --covariances and --relations which files they do not write where there is no output.
void say_unwritten(const Options& options) {
  std::vector<std::string> names;
  for (const ExtraFile& file : extra_files(options)) {
    if (file.extra == Extra::kCovariances || file.extra == Extra::kRelations) names.emplace_back(file.in_folder);
  }
  if (!names.empty()) say(fmt::format("{} would be written with --output", fmt::join(names, " and ")));
}

/// Says where a trajectory of one file mixes several sessions.
template <int Dim>
void say_sessions(const GlobalMap<Dim>& map, const std::filesystem::path& output) {
  if (extension_of(output) != ".tum" || sessions_by_name(map.pose_ids).size() < 2) return;
  say(fmt::format(
      "{}: has the poses of several sessions one after the other, and does not say of which each is; `mapjoin run -o DIR` "
      "writes a trajectory of each, too",
      output.string()));
}

/// The log that was joined; if fixes with levers hold it, with the values of the map, at which levers are taken off.
template <int Dim>
Log<Dim> with_values_for_levers(Log<Dim> log, const GlobalMap<Dim>& map) {
  if (has_levers(log.graph)) log.initial = {map.poses, map.features};
  return log;
}

/// True if a file is the record of the associations in one of the stores that were joined.
bool is_of_store(const std::filesystem::path& file, const std::vector<std::filesystem::path>& inputs) {
  return std::ranges::any_of(inputs, [&](const std::filesystem::path& input) {
    return are_one_file(extra_file(Extra::kAssociations, input), file) && may_hold_maps(input);
  });
}

}  // namespace

CommandRun::CommandRun(const std::string& command, const Options& options, std::stop_token stop)
    : run_report(command, options),
      options_(options),
      stop_(std::move(stop)),
      threads_(tbb::global_control::max_allowed_parallelism, thread_count(options)),
      progress_(!options.quiet),
      run_options_(options.run) {
  if (progress_.is_shown()) {
    run_options_.progress = [this](Stage stage, std::size_t done, std::size_t to_do) {
      progress_.show(to_string(stage), done, to_do);
    };
  }
  run_options_.covariances = !options.truth.empty();
  run_options_.marginals = options.covariances || options.relations;
  run_options_.most_memory = std::llround(1e6 * std::min(options.most_memory_mb, 1e12));
}

void CommandRun::prepare(const NamedFiles& outputs) {
  check_writable(outputs);
  if (options_.truth.empty()) return;
  truth_ = timed(run_report.read_seconds, [&] { return TruthFile(options_.truth, kSameTime, options_.read); });
  const auto is_associated = [](const std::filesystem::path& input) { return has_extra_file(Extra::kAssociations, input); };
  if (options_.association || std::ranges::any_of(inputs(), is_associated)) truth_->leave_features_out();
}

void CommandRun::check_interrupted() const {
  if (stop_.stop_requested()) fail(ErrorKind::kInterrupted, "interrupted");
}

template <int Dim>
void CommandRun::certify(RunResult<Dim>& result) {
  if (!result.covariances) return;
  run_report.covariances = result.covariances->estimate();
  if (result.marginals) run_report.deviations = deviations_of(*result.marginals);
  if (options_.covariances) {
    result.map.pose_covariances = result.marginals->poses;
    result.map.feature_covariances = result.marginals->features;
  }
  if (!truth_) return;
  run_report.consistency = timed(run_report.figures.seconds.covariances,
                                 [&] { return consistency(*result.covariances, truth_->of(result.map), stop_).value(); });
}

template <int Dim>
void CommandRun::measure(const GlobalMap<Dim>& map, const TruthFile& truth, const ErrorOptions& options) {
  run_report.errors = errors_of(map, truth, options);
  run_report.truth_without_features = truth.leaves_features_out();
  if (truth.compares_features()) run_report.features_not_in_truth = map.features.size() - run_report.errors->known_features;
}

template <int Dim>
void CommandRun::take(RunResult<Dim>& result) {
  run_report.describe(result);
  certify(result);
  if (truth_) measure(result.map, *truth_);
  check_interrupted();
}

void CommandRun::check_names(const PoseIds& poses, const FeatureIds& features) const {
  if (options_.output.empty()) return;
  if (is_written_as_g2o(options_.output)) (void)number_for_g2o(poses, features).value();
  if (extension_of(options_.output) == ".mat") demand(check_mat_ids(poses, features));
}

template <int Dim>
void CommandRun::write_map(RunResult<Dim>& result, const Log<Dim>* log) {
  take(result);
  if (options_.output.empty()) {
    progress_.close();
    return say_unwritten(options_);
  }
  const Stopwatch watch(run_report.write_seconds);
  demand(write_map_file(result.map, log, options_.output));
  if (is_written_as_g2o(options_.output)) {
    run_report.renamed = in_words(number_for_g2o(result.map.pose_ids, result.map.feature_ids).value());
  }
  for (const auto& file : map_files(options_.output)) run_report.files.push_back(file.string());
  for (const ExtraFile& extra : files_beside(options_, result.marginals.has_value())) {
    const std::filesystem::path file = extra_file(extra.extra, options_.output);
    demand(write_extra(extra.extra, result, log, file));
    run_report.files.push_back(file.string());
  }
  say_what_is_left();
  say_sessions(result.map, options_.output);
}

void CommandRun::say_what_is_left() {
  progress_.close();
  if (is_stream(options_.output)) return say_what_is_left_out();
  for (const std::filesystem::path& file : extra_files_left(options_.output, run_report.files)) {
    if (!is_of_store(file, inputs())) say_not_written(file);
  }
}

void CommandRun::say_what_is_left_out() const {
  std::vector<std::string> names;
  for (const ExtraFile& file : extra_files(options_)) {
    if (file.beside) names.emplace_back(file.in_folder);
  }
  if (names.empty()) return;
  say(fmt::format("{}: is no file beside which others could lie: {} not written", options_.output.string(),
                  fmt::join(names, " and ")));
}

template <int Dim>
Expected<void> CommandRun::write_extra(Extra extra, const RunResult<Dim>& result, const Log<Dim>* log,
                                       const std::filesystem::path& file) const {
  const GlobalMap<Dim>& map = result.map;
  switch (extra) {
    case Extra::kCovariances:
      return write_covariances(map, *run_report.covariances, file);
    case Extra::kRelations:
      return write_relations(map, *result.marginals, file);
    case Extra::kAssociations:
      return write_file(file, associations_as_csv(run_report));
    case Extra::kRejected:
      return write_file(file, rejected_as_csv(run_report));
    case Extra::kInliers:
      return write_g2o(with_values_for_levers(*log, map), file);
    case Extra::kGeographic:
      return write_geographic_csv(map, run_report.gps->frame, file);
    default:
      return write_geojson(map, run_report.gps->frame, file);
  }
}

template <typename Data>
std::optional<std::string> CommandRun::features_apart(const Data& data, const RunFigures& figures) const {
  const bool is_doubtful = figures.fit.verdict == Verdict::kMisfit || figures.fit.verdict == Verdict::kUnconverged;
  if (!asks_features() || options_.association || !is_doubtful) return std::nullopt;
  const auto compared = worst_name_fit(data, options_.confidence, stop_);
  if (!compared && compared.error().kind == ErrorKind::kInterrupted) demand(tl::unexpected(compared.error()));
  const auto fit = compared.value_or(std::nullopt);  // what cannot be joined alone cannot be compared
  if (!fit || fit->is_good()) return std::nullopt;
  return fmt::format(
      "{} and {} name {} alike that lie differently in the map of each (of the distances between these {:.0f} % agree): "
      "{}--features own where ids mean other features in each input, --features shared where they mean the same all the same",
      to_string(fit->first), to_string(fit->second), plural(fit->features, "feature"), 100.0 * fit->alike,
      options_.further.empty() ? "`mapjoin build` with " : "");
}

void CommandRun::write_associations() {
  if (!run_report.association || options_.output.empty()) return;
  const std::filesystem::path file = extra_file(Extra::kAssociations, options_.output);
  demand(write_file(file, associations_as_csv(run_report)));
  run_report.files.push_back(file.string());
}

void CommandRun::tell(const std::string& json, const std::string& text) {
  progress_.close();
  if (options_.report_on_stdout()) return demand(write_stdout(json));
  if (!options_.report.empty()) demand(write_file(options_.report, json));
  if (options_.has_summary()) demand(write_stdout(text));
}

ExitCode CommandRun::conclude() {
  tell(report(run_report), summary(run_report));
  if (!run_report.is_joined) return ExitCode::kDone;
  const bool is_certified = !run_report.figures.no_covariances;
  if (!is_certified) say(why_not_certified(run_report));
  if (!run_report.figures.converged()) say(why_not_converged(run_report));
  if (!run_report.figures.converged()) return ExitCode::kDidNotConverge;
  if (!is_certified) return ExitCode::kBadInput;
  if (!options_.strict || run_report.figures.fit.verdict == Verdict::kFits) return ExitCode::kDone;
  say(why_not_trusted(run_report));
  return ExitCode::kDoesNotFit;
}

void CommandRun::hand_over(const StudyOutput& output, std::optional<OutputFolder>& folder) {
  std::vector<std::string> names;
  for (const auto& [name, text] : output.files) {
    if (!folder) break;
    demand(write_file(folder->aside(name), text));
    names.push_back(name);
  }
  if (folder) folder->commit(names);
  tell(output.json, output.text);
}

template std::optional<std::string> CommandRun::features_apart(const Log<2>&, const RunFigures&) const;
template std::optional<std::string> CommandRun::features_apart(const Log<3>&, const RunFigures&) const;
template std::optional<std::string> CommandRun::features_apart(const SubmapSet<2>&, const RunFigures&) const;
template std::optional<std::string> CommandRun::features_apart(const SubmapSet<3>&, const RunFigures&) const;
template void CommandRun::measure(const GlobalMap<2>&, const TruthFile&, const ErrorOptions&);
template void CommandRun::measure(const GlobalMap<3>&, const TruthFile&, const ErrorOptions&);
template void CommandRun::take(RunResult<2>&);
template void CommandRun::take(RunResult<3>&);
template Expected<void> CommandRun::write_extra(Extra, const RunResult<2>&, const Log<2>*, const std::filesystem::path&) const;
template Expected<void> CommandRun::write_extra(Extra, const RunResult<3>&, const Log<3>*, const std::filesystem::path&) const;
template void CommandRun::write_map(RunResult<2>&, const Log<2>*);
template void CommandRun::write_map(RunResult<3>&, const Log<3>*);

}  // namespace mapjoin::apps
