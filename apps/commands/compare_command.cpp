// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin compare`: joining beside full SLAM on one log, with a report in JSON and tables.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/compare_report.hpp>
#include <apps/report/errors.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace mapjoin {

static void to_json(apps::Json& json, const MapDifference& difference) {
  json = {{"poses", difference.poses}, {"features", difference.features}};
}

namespace apps {
namespace {

constexpr int kLongestMap = 1'000'000;

struct CompareOptions : Options {
  std::vector<int> poses_per_map = {5, 20, 60};
};

/// The names of the files of the folder.
std::vector<std::string> names_of(const Options& options) {
  std::vector<std::string> names = {"compare.json", "compare.csv", "compare.html"};
  if (options.robust) names.emplace_back(name_in_folder(Extra::kRejected));
  return names;
}

/// A number of poses from 2 on: 1 would be full SLAM, which is there in any case.
std::optional<int> poses_in(const std::string& word) {
  const std::optional<int> number = number_in<int>(word);
  return number && *number >= 2 && *number <= kLongestMap ? number : std::nullopt;
}

/// The truth of a log, at least two poses, if a file is given.
template <int Dim>
std::optional<Truth<Dim>> truth_of(const Log<Dim>& log, const CommandRun& command_run) {
  const std::filesystem::path& path = command_run.options().truth;
  if (path.empty()) return std::nullopt;
  Truth<Dim> truth = command_run.truth().of(log);
  if (std::count_if(truth.poses.begin(), truth.poses.end(), [](const auto& pose) { return pose.has_value(); }) < 2) {
    fail(ErrorKind::kUsage, fmt::format("{}: the truth has fewer than two poses of the log", path.string()));
  }
  return truth;
}

/// The optimum, by run(), with the weights that are not compared.
template <int Dim>
OtherWeights<Dim> other_weights(const Log<Dim>& log, const GlobalMap<Dim>& best, const CommandRun& command_run) {
  OtherWeights<Dim> other;
  other.covariance = log.conventions.covariance;
  auto result = run(log, without_verdict(), command_run.stop());
  command_run.check_interrupted();
  if (!result) {
    other.failure = result.error().message;
    return other;
  }
  other.run = static_cast<const RunFigures&>(*result);
  other.map = std::move(result->map);
  other.from_best = map_difference(other.map, best);
  return other;
}

template <int Dim>
Comparison<Dim> compared(CommandRun& command_run, const CompareOptions& options, const Log<Dim>& log,
                         const std::optional<Truth<Dim>>& truth) {
  ComparisonOptions<Dim> comparing;
  comparing.cases = compared_cases(options.poses_per_map);
  comparing.truth = truth ? &*truth : nullptr;
  if (command_run.progress().is_shown()) {
    comparing.progress = [&](std::size_t k) {
      command_run.progress().show(to_string(comparing.cases[k]) + ": case", k + 1, comparing.cases.size());
    };
  }
  return compare(log, comparing, command_run.stop()).value();
}

Json json_of(const std::vector<std::size_t>& spans, const EstimateFigures& estimate) {
  const TruthDistance truth = estimate.from_truth.value_or(TruthDistance{});
  Json json = {{"chi2", estimate.chi2},
               {"from_best", estimate.from_best},
               {"from_truth", {{"ate", truth.absolute}, {"rpe", over_spans(spans, truth.spans)}}}};
  json["from_best"]["relative_poses"] = over_spans(spans, estimate.best_spans);
  if (!estimate.from_truth) json["from_truth"] = nullptr;
  return json;
}

Json json_of(const std::vector<std::size_t>& spans, const CaseFigures& figures) {
  const ComparedCase& way = figures.way;
  const RunFigures& run = figures.run;
  Json json = {{"formulation", problem_in_words(way.formulation())},
               {"steps_per_map", way.poses_per_map},
               {"state", way.state},
               {"schedule", schedule_in_words(way)},
               {"result", result_in_words(figures)},
               {"reaches_best", figures.reaches_best}};
  json.update(if_known(figures.has_map(), {{"local_maps", run.local_maps},
                                           {"join",
                                            {{"status", run.join.status},
                                             {"iterations", figures.join_iterations()},
                                             {"chi2", run.join.chi2},
                                             {"dof", run.join.dof}}},
                                           {"polish_iterations", figures.polish_iterations()},
                                           {"system_bytes", run.joint_bytes},
                                           {"joined", json_of(spans, figures.joined)},
                                           {"polished", json_of(spans, figures.polished)}}));
  json["effort"] = {{"seconds", figures.effort.seconds},
                    {"cpu_seconds", figures.effort.cpu_seconds},
                    {"memory_bytes", figures.effort.memory}};
  return json;
}

template <int Dim>
Json json_of(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights<Dim>& other) {
  Json json = report_head(run_report);
  json["dof"] = comparison.cases[comparison.best].run.dof;
  json["best"] = comparison.best;
  json["spans"] = comparison.spans;
  json["cases"] = Json::array();
  for (const CaseFigures& figures : comparison.cases) json["cases"].push_back(json_of(comparison.spans, figures));
  const bool is_known = other.failure.empty();
  json["other_weights"] = {{"covariance", other.covariance}, {"failure", is_known ? Json() : Json(other.failure)}};
  json["other_weights"].update(
      if_known(is_known, {{"chi2", other.run.chi2}, {"converged", other.run.converged()}, {"from_best", other.from_best}}));
  return json;
}

template <int Dim>
std::string in_words(const OtherWeights<Dim>& other) {
  if (!other.failure.empty()) return other.failure;
  const MapDifference& apart = other.from_best;
  const std::string features = apart.features.count > 0 ? fmt::format(", features {:.2g} m", apart.features.rms) : "";
  const std::string unconverged = other.run.converged() ? "" : unconverged_in_words(other.run) + ", ";
  return fmt::format("{}chi2 {:.10g}; from the best map: poses {:.2g} m{} (RMS)", unconverged, other.run.chi2,
                     apart.poses.translation.rms, features);
}

template <int Dim>
std::string summary_of(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights<Dim>& other,
                       const std::vector<NamedTable>& tables) {
  const CaseFigures& best = comparison.cases[comparison.best];
  Lines lines;
  add_input(run_report, lines);
  add_convention(run_report, lines);
  lines.add("best", fmt::format("chi2 {:.10g}, dof {}", best.polished.chi2, best.run.dof));
  lines.add(to_string(other.covariance), in_words(other));
  for (const std::string& file : run_report.files) lines.add("written", file);
  for (const std::string& note : notes_of(run_report, comparison)) lines.add("note", note);
  std::string text = lines.text();
  for (const NamedTable& named : tables) text += fmt::format("\n{}\n{}", named.name, aligned(named.table));
  return text;
}

template <int Dim>
StudyOutput compare_output(const Comparison<Dim>& comparison, const OtherWeights<Dim>& other, const Log<Dim>& log,
                           const RunReport& run_report) {
  const Json report = json_of(run_report, comparison, other);
  const std::vector<NamedTable> tables = tables_of(comparison, report["cases"]);
  StudyOutput output{summary_of(run_report, comparison, other, tables), text_of(report), {}};
  if (run_report.files.empty()) return output;
  output.files = {{"compare.json", output.json},
                  {"compare.csv", csv(whole_table(comparison, report["cases"]))},
                  {"compare.html", compare_page(run_report, comparison, other, tables, log.sessions)}};
  if (run_report.robust) output.files.emplace_back(name_in_folder(Extra::kRejected), rejected_as_csv(run_report));
  return output;
}

/// Bad input if a map of several logs shows that they do not share the features of the same ids, and no option says whether
/// they do. The map is made for this alone, with the weights of the files.
template <int Dim>
void demand_shared_features(const CommandRun& command_run, const Log<Dim>& log) {
  if (!command_run.asks_features()) return;
  RunOptions options;
  options.progress = command_run.run_options().progress;
  const auto result = run(log, options, command_run.stop());
  command_run.check_interrupted();
  if (result) command_run.check_shared_features(log, *result);  // otherwise compare() says why
}

/// Says where an earlier call left rejected measurements in the folder.
void say_what_is_left(const OutputFolder& folder) {
  const std::filesystem::path file = folder.file(name_in_folder(Extra::kRejected));
  std::error_code ignored;
  if (std::filesystem::exists(file, ignored)) say_not_written(file);
}

/// Compares on a log, which has the weights of its file.
template <int Dim>
ExitCode compare_on(CommandRun& command_run, const CompareOptions& options, const Log<Dim>& log,
                    std::optional<OutputFolder>& folder) {
  demand_shared_features(command_run, log);
  Log<Dim> identity = log;
  use_identity_covariance(identity);
  const bool by_identity = options.covariance == Covariance::kIdentity;
  const Log<Dim>& here = by_identity ? identity : log;
  command_run.run_report.conventions = here.conventions;
  const Comparison<Dim> comparison = compared(command_run, options, here, truth_of(log, command_run));
  const auto other = other_weights(by_identity ? log : identity, comparison.maps[comparison.best].polished, command_run);
  for (const std::string& name : names_of(options)) {
    if (folder) command_run.run_report.files.push_back(folder->file(name).string());
  }
  command_run.hand_over(compare_output(comparison, other, log, command_run.run_report), folder);
  if (folder && !options.robust) say_what_is_left(*folder);
  if (comparison.cases[comparison.best].run.converged()) return ExitCode::kDone;
  say("the best map did not converge");
  return ExitCode::kDidNotConverge;
}

ExitCode compare_log(const CompareOptions& options, const std::stop_token& stop) {
  Options as_given = options;
  as_given.covariance = Covariance::kOriginal;
  CommandRun command_run("compare", as_given, stop);
  auto folder = output_folder(as_given.output);
  command_run.prepare(report_of(as_given));
  return std::visit([&](const auto& log) { return compare_on(command_run, options, log, folder); }, command_run.read_log());
}

}  // namespace

void declare_compare(Subcommand& command) {
  command.examples(
      "  mapjoin compare data/manhattan2d.g2o\n"
      "  mapjoin compare data/manhattan2d.g2o -o comparison --truth data/manhattan2d.truth.tum\n"
      "  mapjoin compare data/manhattan3d.g2o --poses-per-map 10,40 --report -");
  const auto options = std::make_shared<CompareOptions>();
  command.argument("LOG", options->input, kLogFormats);
  add_further_logs(command, *options);
  add_one_part(command, *options);
  command.path("-o,--output", options->output, "DIR",
               "Write compare.json, compare.csv and compare.html into this folder, with --robust rejected.csv, too");
  command.list("--poses-per-map", "N,N,...", "Cut the log into local maps after so many poses, each in its turn [5,20,60]",
               options->poses_per_map, poses_in,
               fmt::format("not whole numbers from 2 to {} with commas between them", kLongestMap));
  command.path("--truth", options->truth, "FILE", "Measure the errors against this map, too: " + kTruthFiles);
  add_robust(command, *options, "rejected.csv in the folder names them");
  add_confidence(command, *options, "--robust");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_reporting(command, *options);
  command.check(
      [options] { return output_conflicts(inputs_of(*options, "LOG"), outputs_of_folder(*options, names_of(*options))); });
  command.act([options](const std::stop_token& stop) { return compare_log(*options, stop); });
}

}  // namespace apps
}  // namespace mapjoin
