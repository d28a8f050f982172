// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin compare`: joining beside full SLAM on one log.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <memory>
#include <optional>
#include <utility>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin compare data/manhattan2d.g2o\n"
    "  mapjoin compare data/manhattan2d.g2o -o comparison --truth data/manhattan2d.truth.tum\n"
    "  mapjoin compare data/manhattan3d.g2o --poses-per-map 10,40 --report -";

const std::vector<std::string> kFiles = {"compare.json", "compare.csv", "compare.html"};

constexpr int kLongestMap = 1'000'000;

struct CompareOptions {
  Options common;
  std::vector<int> poses_per_map = {5, 20, 60};
};

/// Whole numbers with commas between them. 1 would be full SLAM, which is there in any case.
std::optional<std::string> take_list(const std::string& word, std::vector<int>& list) {
  list.clear();
  for (const std::string& one : words_between_commas(word)) {
    const std::optional<int> number = number_in<int>(one);
    if (!number || *number < 2 || *number > kLongestMap) {
      return fmt::format("not whole numbers from 2 to {} with commas between them", kLongestMap);
    }
    if (std::find(list.begin(), list.end(), *number) == list.end()) list.push_back(*number);
  }
  return std::nullopt;
}

/// What the maps of a log will have, but for their values.
template <int Dim>
GlobalMap<Dim> outline_of(const Log<Dim>& log) {
  GlobalMap<Dim> map;
  map.pose_ids = log.poses;
  map.poses.resize(log.poses.size());
  map.feature_ids = log.features;
  map.features.resize(log.features.size(), Point<Dim>::Zero());
  map.stamps_ns = log.stamps_ns;
  return map;
}

/// The truth of a log, where a file of it is given: at least two poses.
template <int Dim>
std::optional<Truth<Dim>> truth_of(const Log<Dim>& log, const std::filesystem::path& path) {
  if (path.empty()) return std::nullopt;
  Truth<Dim> truth = TruthFile::open(path).value().of(outline_of(log)).value();
  if (std::count_if(truth.poses.begin(), truth.poses.end(), [](const auto& pose) { return pose.has_value(); }) < 2) {
    fail(ErrorKind::kUsage, fmt::format("{}: the truth has fewer than two poses of the log", path.string()));
  }
  return truth;
}

/// The optimum with the weights that are not compared, by mapjoin's default.
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
  other.chi2 = result->chi2;
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

/// `log` has the weights that the file gives.
template <int Dim>
ExitCode compare_on(CommandRun& command_run, const CompareOptions& options, const Log<Dim>& log,
                    std::optional<OutputFolder>& folder) {
  Log<Dim> identity = log;
  use_identity_covariance(identity);
  const bool by_identity = options.common.covariance == Covariance::kIdentity;
  const Log<Dim>& here = by_identity ? identity : log;
  command_run.run_report.describe(here);
  const Comparison<Dim> comparison = compared(command_run, options, here, truth_of(log, options.common.truth));
  const auto other = other_weights(by_identity ? log : identity, comparison.maps[comparison.best].polished, command_run);
  for (const std::string& name : kFiles) {
    if (folder) command_run.run_report.files.push_back(folder->file(name).string());
  }
  command_run.hand_over(compare_output(comparison, other, log, command_run.run_report), folder);
  if (comparison.cases[comparison.best].run.converged()) return ExitCode::kDone;
  say("the best map did not converge");
  return ExitCode::kDidNotConverge;
}

ExitCode compare_log(const CompareOptions& options, const std::stop_token& stop) {
  Options as_given = options.common;
  as_given.covariance = Covariance::kOriginal;
  as_given.truth.clear();
  CommandRun command_run("compare", as_given, stop);
  auto folder = output_folder(as_given.output).value();
  command_run.prepare(report_of(as_given));
  return std::visit([&](const auto& log) { return compare_on(command_run, options, log, folder); }, command_run.read_log());
}

}  // namespace

void declare_compare(Subcommand& command) {
  command.examples(kExamples);
  const auto options = std::make_shared<CompareOptions>();
  Options& common = options->common;
  command.argument("LOG", common.input, kLogFormats);
  command.path("-o,--output", common.output, "DIR", "Write compare.json, compare.csv and compare.html into this folder");
  command.option("--poses-per-map", "N,N,...", "Cut the log into local maps after so many poses, each in its turn [5,20,60]",
                 [options](const std::string& word) { return take_list(word, options->poses_per_map); });
  command.path("--truth", common.truth, "FILE", "Measure the errors against this map, too: .tum, else g2o with vertices");
  add_reading(command, common);
  add_reporting(command, common);
  command.check(
      [options] { return output_conflicts(inputs_of(options->common, "LOG"), outputs_of_folder(options->common, kFiles)); });
  command.act([options](const std::stop_token& stop) { return compare_log(*options, stop); });
}

}  // namespace mapjoin::apps
