// SPDX-License-Identifier: BSD-3-Clause
// `mapjoin check`: what could be wrong with a log or with local maps, before they are joined.

#include <fmt/format.h>

#include <algorithm>
#include <apps/commands/command_run.hpp>
#include <apps/commands/commands.hpp>
#include <apps/report/check_report.hpp>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/measure/chi2.hpp>
#include <memory>
#include <variant>

namespace mapjoin::apps {
namespace {

constexpr const char* kExamples =
    "  mapjoin check data/manhattan2d.g2o\n"
    "  mapjoin check log.g2o --estimate none --report check.json\n"
    "  mapjoin check MAPS --report - | jq '.findings[].text'\n"
    "Exit codes: 0 nothing to warn of, 1 there are warnings or errors; else as always.";

struct CheckOptions : Options {
  CheckedEstimate estimate = CheckedEstimate::kJoined;
};

void append(Findings more, Checked& checked) {
  for (Finding& finding : more) checked.findings.push_back(std::move(finding));
}

/// Takes the fits at an estimate into the report.
void take_fits(std::vector<KindFit> fits, std::int64_t dof, Checked& checked) {
  append(check_fit(fits, dof), checked);
  checked.fits = std::move(fits);
  checked.dof = dof;
}

template <int Dim>
std::vector<KindFit> fits_in(const RunResult<Dim>& result, const Log<Dim>& log) {
  return fits_of(log, State<Dim>{result.map.poses, result.map.features});
}

/// Of each map as one observation.
template <int Dim>
std::vector<KindFit> fits_in(const RunResult<Dim>& result, const MapSet<Dim>& set) {
  std::vector<WeighedResidual> residuals;
  for (const MapFit& fit : result.maps) residuals.push_back({fit.chi2, fit.rows});
  return {kind_fit("local maps", residuals, [&](std::size_t m) {
    const auto name = [&](Index pose) { return to_string(set.poses[static_cast<std::size_t>(pose)]); };
    return fmt::format("{} to {}", name(result.maps[m].base), name(result.maps[m].end));
  })};
}

template <typename Content>
void fit_joined(const CommandRun& command_run, const Content& content, Checked& checked) {
  const auto result = run(content, command_run.run_options(), command_run.stop());
  if (!result && result.error().kind == ErrorKind::kBadInput) {
    checked.findings.push_back({FindingLevel::kError, "undetermined", result.error().message, {}});
    return;
  }
  if (!result.value().converged()) {
    checked.findings.push_back(
        {FindingLevel::kWarning, "not_converged", "the map that residuals are weighed at did not converge", {}});
  }
  take_fits(fits_in(*result, content), result->dof, checked);
}

template <int Dim>
void fit_values(const Log<Dim>& log, Checked& checked) {
  if (log.initial_poses.empty() || log.initial_features.size() < log.features.size()) {
    fail(ErrorKind::kUsage, log.source + ": has no values of every pose and feature for --estimate file");
  }
  const std::size_t held = std::max<std::size_t>(1, log.fixed.size());
  take_fits(fits_of(log, State<Dim>{log.initial_poses, log.initial_features}), degrees_of_freedom(log, held), checked);
}
template <int Dim>
void fit_values(const MapSet<Dim>& set, Checked&) {
  fail(ErrorKind::kUsage, set.source + ": local maps have no values for --estimate file");
}

template <int Dim>
void check_numbers(const Log<Dim>& log, Checked& checked) {
  append(check_repeats(log), checked);
  append(check_units(log), checked);
}
template <int Dim>
void check_numbers(const MapSet<Dim>&, Checked&) {}

template <typename Content>
Checked checked_content(const CommandRun& command_run, CheckedEstimate estimate, const Content& content) {
  Checked checked{estimate, check_structure(content), {}, 0};
  check_numbers(content, checked);
  const bool falls_apart = checked.count(FindingLevel::kError) > 0;
  if (estimate == CheckedEstimate::kFile) fit_values(content, checked);
  if (estimate == CheckedEstimate::kJoined && !falls_apart) fit_joined(command_run, content, checked);
  return checked;
}
/// A store has its log, of which its maps are made.
template <int Dim>
Checked checked_content(const CommandRun& command_run, CheckedEstimate estimate, const StoredMaps<Dim>& stored) {
  return checked_content(command_run, estimate, stored.log);
}

ExitCode check_input(const CheckOptions& options, const std::stop_token& stop) {
  CommandRun command_run("check", options, stop);
  command_run.prepare(report_of(options));
  const Checked checked = command_run.with_log_or_maps(
      [&](const auto& content) { return checked_content(command_run, options.estimate, content); });
  command_run.tell(check_report(command_run.run_report, checked), check_summary(command_run.run_report, checked));
  return checked.count(FindingLevel::kWarning) > 0 ? ExitCode::kFindings : ExitCode::kDone;
}

}  // namespace

void declare_check(Subcommand& command) {
  command.examples(kExamples);
  const auto options = std::make_shared<CheckOptions>();
  command.argument("FILE", options->input, "A log, a store, or a folder or archive of local maps");
  command.choice("--estimate", options->estimate,
                 "Where residuals are weighed: at the joined map, as `mapjoin run` would find it; at the "
                 "file's own values; or nowhere, which is fastest");
  add_reading(command, *options);
  add_reporting(command, *options);
  command.check([options] { return output_conflicts(inputs_of(*options, "FILE"), report_of(*options)); });
  command.act([options](const std::stop_token& stop) { return check_input(*options, stop); });
}

}  // namespace mapjoin::apps
