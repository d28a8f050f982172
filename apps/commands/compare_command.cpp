// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin compare`: joining beside full SLAM on one log.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/commands/study.hpp>
#include <apps/console.hpp>
#include <apps/output_conflicts.hpp>
#include <apps/report/compare_report.hpp>
#include <apps/report/report.hpp>
#include <mapjoin/io/files/output_file.hpp>
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

constexpr Index kLongestMap = 1'000'000;

struct CompareOptions {
  Options common;
  std::vector<Index> poses_per_map = {5, 20, 60};
};

/// Whole numbers with commas between them. 1 would be full SLAM, which is there in any case.
std::optional<std::string> take_list(const std::string& word, std::vector<Index>& list) {
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

const std::vector<std::string> kNames = {"compare.json", "compare.csv", "compare.html"};

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
Expected<std::optional<Truth<Dim>>> truth_of(const Log<Dim>& log, const std::filesystem::path& path) {
  if (path.empty()) return std::optional<Truth<Dim>>();
  const auto file = TruthFile::open(path);
  if (!file) return tl::unexpected(file.error());
  auto truth = file->of(outline_of(log));
  if (!truth) return tl::unexpected(truth.error());
  const auto known = std::count_if(truth->poses.begin(), truth->poses.end(), [](const auto& pose) { return pose.has_value(); });
  if (known < 2) {
    return tl::unexpected(
        Error{ErrorKind::kUsage, fmt::format("{}: the truth has fewer than two poses of the log", path.string())});
  }
  return std::optional<Truth<Dim>>(*std::move(truth));
}

/// The optimum with the weights that are not compared, by mapjoin's default; `map` has no poses where there is none.
template <int Dim>
Expected<OtherWeights> other_weights(const Log<Dim>& log, const GlobalMap<Dim>& best, const std::stop_token& stop,
                                     GlobalMap<Dim>& map) {
  OtherWeights other;
  other.covariance = log.conventions.covariance;
  auto result = run(log, RunOptions{}, stop);
  if (stop.stop_requested()) return tl::unexpected(Error{ErrorKind::kInterrupted, "interrupted"});
  if (!result) {
    other.failure = result.error().message;
    return other;
  }
  other.chi2 = result->chi2;
  map = std::move(result->map);
  other.from_best = map_difference(map, best);
  return other;
}

std::string in_words(const OtherWeights& other) {
  if (!other.failure.empty()) return other.failure;
  const MapDifference& apart = other.from_best;
  const std::string features = apart.features.count > 0 ? fmt::format(", features {:.2g} m", apart.features.rms) : "";
  return fmt::format("chi2 {:.10g}; from the best map: poses {:.2g} m{} (RMS)", other.chi2, apart.poses.translation.rms,
                     features);
}

std::string compare_summary(const RunReport& run_report, const ComparisonFigures& comparison, const OtherWeights& other) {
  const CaseFigures& best = comparison.cases[comparison.best];
  Lines lines;
  lines.add("input", fmt::format("{}: {}", run_report.input, counts_in_words(run_report)));
  lines.add("convention", conventions_in_words(run_report.conventions, run_report.dimension));
  lines.add("best", fmt::format("chi2 {:.10g}, dof {}", best.polished.chi2, best.run.dof));
  lines.add(to_string(other.covariance), in_words(other));
  for (const std::string& file : run_report.files) lines.add("written", file);
  std::string text = lines.text();
  for (const NamedTable& named : tables_of(comparison)) text += fmt::format("\n{}\n{}", named.name, aligned(named.table));
  return text;
}

/// What is read of it by people and programs; the page is made for the folder only.
template <int Dim>
StudyOutput output_of(const RunReport& run_report, const Comparison<Dim>& comparison, const OtherWeights& other,
                      const GlobalMap<Dim>& other_map, const Log<Dim>& log, bool has_folder) {
  StudyOutput output{compare_summary(run_report, comparison, other), compare_report(run_report, comparison, other), {}};
  if (!has_folder) return output;
  output.files = {{kNames[0], output.json},
                  {kNames[1], csv(whole_table(comparison))},
                  {kNames[2], compare_page(run_report, comparison, other, other_map, log.sessions)}};
  return output;
}

template <int Dim>
Expected<Comparison<Dim>> compared(const CommandRun& command_run, const CompareOptions& options, const Log<Dim>& log,
                                   const Truth<Dim>* truth) {
  Progress progress(!options.common.quiet);
  const auto say_case = progress.callback_in_words();
  ComparisonOptions<Dim> comparing;
  comparing.cases = compared_cases(options.poses_per_map);
  comparing.truth = truth;
  if (say_case) {
    comparing.progress = [&](std::size_t k) {
      say_case(to_string(comparing.cases[k]) + ": case", k + 1, comparing.cases.size());
    };
  }
  return compare(log, comparing, command_run.stop());
}

/// `log` has the weights that the file gives.
template <int Dim>
Expected<ExitCode> compare_on(CommandRun& command_run, const CompareOptions& options, const Log<Dim>& log,
                              std::optional<OutputFolder>& folder) {
  Log<Dim> identity = log;
  use_identity_covariance(identity);
  const bool by_identity = options.common.covariance == Covariance::kIdentity;
  const Log<Dim>& here = by_identity ? identity : log;
  command_run.run_report.describe(here);
  const auto truth = truth_of(log, options.common.truth);
  if (!truth) return tl::unexpected(truth.error());
  const auto comparison = compared(command_run, options, here, *truth ? &**truth : nullptr);
  if (!comparison) return tl::unexpected(comparison.error());
  GlobalMap<Dim> other_map;
  const auto other =
      other_weights(by_identity ? log : identity, comparison->maps[comparison->best].polished, command_run.stop(), other_map);
  if (!other) return tl::unexpected(other.error());
  if (folder) {
    for (const std::string& name : kNames) command_run.run_report.files.push_back(folder->file(name).string());
  }
  const StudyOutput output = output_of(command_run.run_report, *comparison, *other, other_map, log, folder.has_value());
  if (auto told = hand_over(output, command_run, folder); !told) return tl::unexpected(told.error());
  if (comparison->cases[comparison->best].run.converged()) return ExitCode::kDone;
  say("the best map did not converge");
  return ExitCode::kDidNotConverge;
}

Expected<ExitCode> compare_log(const CompareOptions& options, const std::stop_token& stop) {
  Options as_given = options.common;
  as_given.covariance = Covariance::kOriginal;
  CommandRun command_run("compare", as_given, stop);
  auto folder = output_folder(as_given.output);
  if (!folder) return tl::unexpected(folder.error());
  if (auto ready = command_run.check_report(); !ready) return tl::unexpected(ready.error());
  const auto log = command_run.read_log();
  if (!log) return tl::unexpected(log.error());
  return std::visit([&](const auto& any) { return compare_on(command_run, options, any, *folder); }, *log);
}

void declare(Subcommand& command) {
  const auto options = std::make_shared<CompareOptions>();
  Options& common = options->common;
  command.argument("LOG", common.input, kLogFormats);
  command.path("-o,--output", common.output, "DIR", "Write compare.json, compare.csv and compare.html into this folder");
  command.option("--poses-per-map", "N,N,...", "Cut the log into local maps after so many poses, each in its turn [5,20,60]",
                 [options](const std::string& word) { return take_list(word, options->poses_per_map); });
  command.path("--truth", common.truth, "FILE", "Measure the errors against this map, too: .tum, else g2o with vertices");
  add_reading(command, common);
  add_reporting(command, common);
  command.check([options] { return output_conflicts(files_of_folder(options->common, "LOG", kNames)); });
  command.act([options](const std::stop_token& stop) { return compare_log(*options, stop); });
}

}  // namespace

std::unique_ptr<Subcommand> compare_command(CLI::App& app) {
  return std::make_unique<Subcommand>(
      app, "compare", "Joining beside full SLAM on one log: what each takes, and how far its map is from the best", kExamples,
      declare);
}

}  // namespace mapjoin::apps
