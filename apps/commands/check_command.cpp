// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin check`: possible faults of a log or of local maps, before they are joined.

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/certainty.hpp>
#include <apps/commands/command_run.hpp>
#include <apps/commands/subcommand.hpp>
#include <apps/report/json.hpp>
#include <apps/report/report.hpp>
#include <apps/report/verdict.hpp>
#include <cmath>
#include <iterator>
#include <limits>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/check/fit.hpp>
#include <mapjoin/io/files/output_file.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <memory>
#include <numeric>
#include <variant>

namespace mapjoin::apps {
namespace {

/// The map at which residuals are weighed.
enum class CheckedEstimate : std::uint8_t { kJoined, kFile, kNone };
constexpr auto enum_names(CheckedEstimate) {
  return std::to_array<EnumName<CheckedEstimate>>(
      {{CheckedEstimate::kJoined, "joined"}, {CheckedEstimate::kFile, "file"}, {CheckedEstimate::kNone, "none"}});
}

struct Checked {
  CheckedEstimate estimate = CheckedEstimate::kJoined;
  Findings findings;
  std::vector<KindFit> fits;  ///< Empty if residuals were not weighed.
  std::int64_t dof = 0;       ///< Degrees of freedom of all fits together.

  /// The chi2 of all fits together.
  double chi2() const {
    return std::accumulate(fits.begin(), fits.end(), 0.0, [](double sum, const KindFit& fit) { return sum + fit.chi2; });
  }
  void add(Findings more) { std::ranges::move(more, std::back_inserter(findings)); }
  /// The number of findings of this level or a graver one.
  std::int64_t count(FindingLevel least) const {
    return std::count_if(findings.begin(), findings.end(), [&](const Finding& finding) { return finding.level >= least; });
  }
};

struct CheckOptions : Options {
  CheckedEstimate estimate = CheckedEstimate::kJoined;
  std::optional<std::size_t> most;  ///< Number of places to be named of a finding.
};

/// Takes "all" or a number for --most; returns a violation otherwise.
std::optional<std::string> take_most(const std::string& word, CheckOptions& options) {
  constexpr std::size_t kAll = std::numeric_limits<std::size_t>::max();
  options.most = word == "all" ? kAll : number_in<std::size_t>(word);
  return options.most > 0U ? std::nullopt : std::optional<std::string>("not all or a whole number from 1 on");
}

/// Takes the fits at an estimate into the report.
void take_fits(std::vector<KindFit> fits, std::int64_t dof, Checked& checked) {
  checked.add(check_fit(fits, dof));
  checked.fits = std::move(fits);
  checked.dof = dof;
}

template <int Dim>
std::vector<KindFit> fits_in(const RunResult<Dim>& result, const Log<Dim>& log) {
  return fits_of(log, Values<Dim>{result.map.poses, result.map.features});
}

/// The fit of the local maps, each as one observation.
template <int Dim>
std::vector<KindFit> fits_in(const RunResult<Dim>& result, const SubmapSet<Dim>& set) {
  std::vector<WeighedResidual> residuals;
  for (const MapFit& fit : result.maps) residuals.push_back({fit.chi2, fit.rows});
  return {kind_fit("local maps", residuals, [&](std::size_t m) {
    const auto name = [&](PoseIndex pose) { return to_string(set.poses[pose]); };
    return fmt::format("{} to {}", name(result.maps[m].base), name(result.maps[m].end));
  })};
}

/// A finding if positions are not known to a tenth of the map's size.
template <int Dim>
Findings check_certainty(const RunResult<Dim>& result) {
  if (!result.marginals) return {};
  double largest = 0.0;
  std::string least_known;
  const auto look = [&](const auto& covariances, const auto& ids) {
    for (const auto k : indices(covariances)) {
      const double deviation = position_deviation<Dim>(covariances[k]);
      if (deviation > largest) least_known = to_string(ids[k]);
      largest = std::max(largest, deviation);
    }
  };
  look(result.marginals->poses, result.map.pose_ids);
  look(result.marginals->features, result.map.feature_ids);
  const double extent = extent_of(result.map);
  if (10.0 * largest <= extent) return {};
  return {{largest < extent ? FindingLevel::kNote : FindingLevel::kWarning,
           "uncertain",
           fmt::format("positions are uncertain by up to {:.3g} m ({}) in a map of {:.3g} m", largest, least_known, extent),
           {}}};
}

template <typename Content>
void fit_joined(CommandRun& command_run, const Content& content, Checked& checked) {
  RunOptions options = command_run.run_options();
  options.marginals = true;
  auto result = run(content, options, command_run.stop());
  if (!result && result.error().kind == ErrorKind::kTooLarge)
    result = run(content, command_run.run_options(), command_run.stop());
  if (!result && result.error().kind == ErrorKind::kBadInput) {
    checked.findings.push_back({FindingLevel::kError, "undetermined", result.error().message, {}});
    return;
  }
  if (!result.value().converged()) {
    checked.findings.push_back(
        {FindingLevel::kWarning, "not_converged", "the map that residuals are weighed at did not converge", {}});
  }
  command_run.run_report.describe(*result);
  if (const auto apart = command_run.features_apart(content, *result)) {
    checked.findings.push_back({FindingLevel::kWarning, "other_features", *apart, {}});
  }
  checked.add(verdict_findings(command_run.run_report));
  checked.add(check_certainty(*result));
  take_fits(fits_in(*result, content), result->dof, checked);
}

template <int Dim>
void fit_values(const Log<Dim>& log, Checked& checked) {
  if (log.initial.poses.empty() || log.initial.features.size() < log.features.size()) {
    fail(ErrorKind::kUsage, log.source + ": has no values of every pose and feature for --estimate file");
  }
  take_fits(fits_of(log, log.initial), degrees_of_freedom(log), checked);
  checked.add(check_outliers(checked.fits));
}
template <int Dim>
void fit_values(const SubmapSet<Dim>& set, Checked&) {
  fail(ErrorKind::kUsage, set.source + ": local maps have no values for --estimate file");
}

template <typename Content>
Checked checked_content(CommandRun& command_run, CheckedEstimate estimate, const Content& content) {
  Checked checked{estimate, rejected_findings(command_run.run_report), {}, 0};
  checked.add(check_structure(content));
  if constexpr (requires { content.odometry(); }) {
    checked.add(check_repeats(content));
    checked.add(check_units(content));
  }
  const bool falls_apart = checked.count(FindingLevel::kError) > 0;
  if (estimate == CheckedEstimate::kFile) fit_values(content, checked);
  if (estimate == CheckedEstimate::kJoined && !falls_apart) fit_joined(command_run, content, checked);
  return checked;
}
/// Checks the log in a store, from which its maps are built.
template <int Dim>
Checked checked_content(CommandRun& command_run, CheckedEstimate estimate, const StoredMaps<Dim>& stored) {
  return checked_content(command_run, estimate, stored.log);
}

/// The first few places of a finding.
std::span<const std::string> first_of(const Places& where, std::size_t most) {
  return std::span(where.names).first(std::min(most, where.names.size()));
}

std::string places_in_words(const Places& where, std::size_t most) {
  const auto shown = first_of(where, most);
  const std::string more = where.count > shown.size() ? fmt::format(" and {} more", where.count - shown.size()) : "";
  return fmt::format("{}{}", fmt::join(shown, ", "), more);
}

std::string fit_in_words(const KindFit& fit) {
  std::string text = fmt::format("{}: {:.10g} over {}", fit.kind, fit.chi2, plural(fit.rows, "row"));
  if (std::isfinite(fit.scale)) text += fmt::format(", typical residuals {:.2g} of what covariances say", std::sqrt(fit.scale));
  return text;
}

std::string estimate_in_words(const Checked& checked) {
  if (checked.fits.empty()) return "residuals were not weighed";
  return fmt::format("{:.10g}, dof {}, at {}", checked.chi2(), checked.dof,
                     checked.estimate == CheckedEstimate::kFile ? "the file's values" : "the joined map");
}

std::string summary_of(const RunReport& run_report, const Checked& checked, std::size_t most) {
  Lines lines;
  add_input(run_report, lines, "file");
  lines.add("chi2", estimate_in_words(checked));
  for (const KindFit& fit : checked.fits) lines.add("", fit_in_words(fit));
  add_reading_notes(run_report, lines);
  for (const Finding& finding : checked.findings) {
    lines.add(to_string(finding.level), finding.text);
    if (!finding.where.names.empty()) lines.add("", places_in_words(finding.where, most));
  }
  const auto warnings = checked.count(FindingLevel::kWarning);
  lines.add("found", warnings == 0 ? "nothing to warn of" : fmt::format("{} to look at", warnings));
  return lines.text();
}

std::string report_of(const RunReport& run_report, const Checked& checked, std::size_t most) {
  Json json = report_head(run_report);
  json["estimate"] = checked.estimate;
  json.update(if_known(!checked.fits.empty(), {{"chi2", checked.chi2()}, {"dof", checked.dof}}));
  json["fits"] = Json::array();
  for (const KindFit& fit : checked.fits) {
    json["fits"].push_back({{"kind", fit.kind},
                            {"count", fit.count},
                            {"rows", fit.rows},
                            {"chi2", fit.chi2},
                            {"scale", fit.scale},
                            {"worst", fit.worst},
                            {"outliers", fit.outliers.count}});
  }
  json.update(verdict_of(run_report));
  json["findings"] = Json::array();
  for (const Finding& finding : checked.findings) {
    json["findings"].push_back({{"level", finding.level},
                                {"check", finding.check},
                                {"count", finding.where.count},
                                {"text", finding.text},
                                {"where", first_of(finding.where, most)}});
  }
  return text_of(json);
}

ExitCode check_input(const CheckOptions& options, const std::stop_token& stop) {
  CommandRun command_run("check", options, stop);
  command_run.prepare(outputs_of(options));
  command_run.tells_of_parts = true;
  const Checked checked = command_run.with_log_or_maps(
      [&](const auto& content) { return checked_content(command_run, options.estimate, content); });
  if (!options.output.empty()) demand(write_file(options.output, misfits_as_csv(command_run.run_report)));
  constexpr std::size_t kShown = 3;
  command_run.tell(report_of(command_run.run_report, checked, options.run.most_misfits),
                   summary_of(command_run.run_report, checked, options.most.value_or(kShown)));
  return checked.count(FindingLevel::kWarning) > 0 ? ExitCode::kFindings : ExitCode::kDone;
}

}  // namespace

void declare_check(Subcommand& command) {
  command.examples(
      "  mapjoin check data/manhattan2d.g2o\n"
      "  mapjoin check data/manhattan2d.g2o --estimate none --report check.json\n"
      "  mapjoin check data/manhattan2d.g2o --most all -o misfits.csv\n"
      "Exit codes: 0 nothing to warn of, 1 there are warnings or errors; else as always.");
  const auto options = std::make_shared<CheckOptions>();
  command.argument("FILE", options->input, kLogOrMaps);
  add_further_logs(command, *options);
  command.choice("--estimate", options->estimate,
                 "Where residuals are weighed: at the joined map, as `mapjoin run` would find it; at the "
                 "file's own values; or nowhere, which is fastest");
  command.option("--most", "N|all", "Name so many places of a finding [3; in the report 20]",
                 [options](const std::string& word) { return take_most(word, *options); });
  command.path("-o,--output", options->output, "FILE", "Write what is out of line with the joined map, as CSV");
  add_robust(command, *options, "the finding rejected names them");
  add_confidence(command, *options, "--robust");
  add_reading(command, *options);
  add_inflation(command, *options);
  add_reporting(command, *options);
  command.check([options] { return output_conflicts(inputs_of(*options, "FILE"), outputs_of(*options)); });
  command.check([options]() -> std::vector<std::string> {
    if (options->output.empty() || options->estimate == CheckedEstimate::kJoined) return {};
    return {"--output has what is out of line with the joined map: it goes with --estimate joined"};
  });
  command.act([options](const std::stop_token& stop) {
    options->run.verdict = true;
    options->run.most_misfits = options->most.value_or(options->run.most_misfits);
    return check_input(*options, stop);
  });
}

}  // namespace mapjoin::apps
