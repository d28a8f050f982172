// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/report/check_report.hpp>
#include <apps/report/json.hpp>
#include <apps/report/report.hpp>
#include <cmath>

namespace mapjoin::apps {
namespace {

/// The first few places of a finding.
std::string places_in_words(const Places& where) {
  constexpr std::size_t kShown = 3;
  const auto shown = static_cast<std::ptrdiff_t>(std::min(kShown, where.names.size()));
  const std::string more = where.count > kShown ? fmt::format(" and {} more", where.count - kShown) : "";
  return fmt::format("{}{}", fmt::join(where.names.begin(), where.names.begin() + shown, ", "), more);
}

std::string fit_in_words(const KindFit& fit) {
  std::string text = fmt::format("{}: {:.10g} over {} rows", fit.kind, fit.chi2, fit.rows);
  if (std::isfinite(fit.scale)) text += fmt::format(", typical residuals {:.2g} of what covariances say", std::sqrt(fit.scale));
  return text;
}

std::string estimate_in_words(const Checked& checked) {
  if (checked.fits.empty()) return "residuals were not weighed";
  double chi2 = 0.0;
  for (const KindFit& fit : checked.fits) chi2 += fit.chi2;
  return fmt::format("{:.10g}, dof {}, at {}", chi2, checked.dof,
                     checked.estimate == CheckedEstimate::kFile ? "the file's values" : "the joined map");
}

}  // namespace

std::int64_t Checked::count(FindingLevel least) const {
  return std::count_if(findings.begin(), findings.end(), [&](const Finding& finding) { return finding.level >= least; });
}

std::string check_summary(const RunReport& run_report, const Checked& checked) {
  Lines lines;
  add_input(run_report, lines, "file");
  lines.add("chi2", estimate_in_words(checked));
  for (const KindFit& fit : checked.fits) lines.add("", fit_in_words(fit));
  for (const Finding& finding : checked.findings) {
    lines.add(to_string(finding.level), finding.text);
    if (!finding.where.names.empty()) lines.add("", places_in_words(finding.where));
  }
  const auto warnings = checked.count(FindingLevel::kWarning);
  lines.add("found", warnings == 0 ? "nothing to warn of" : fmt::format("{} to look at", warnings));
  return lines.text();
}

std::string check_report(const RunReport& run_report, const Checked& checked) {
  Json json = report_head(run_report);
  json["estimate"] = checked.estimate;
  json["dof"] = checked.fits.empty() ? std::nullopt : std::optional(checked.dof);
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
  json["findings"] = Json::array();
  for (const Finding& finding : checked.findings) {
    json["findings"].push_back({{"level", finding.level},
                                {"check", finding.check},
                                {"count", finding.where.count},
                                {"text", finding.text},
                                {"where", finding.where.names}});
  }
  return text_of(json);
}

}  // namespace mapjoin::apps
