// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <apps/report/verdict.hpp>
#include <cmath>
#include <mapjoin/io/files/text_line.hpp>
#include <mapjoin/model/error.hpp>

namespace mapjoin::apps {
namespace {

/// The most misfits shown in the summary; the report has more.
constexpr std::size_t kMostShown = 5;

/// The factor by which typical residuals of a kind are larger than their covariances say.
double factor_of(const KindScale& kind) {
  return std::sqrt(kind.scale);
}

/// A factor for people: with two digits, or three where it is 1 but for the third.
std::string in_words(double factor) {
  const std::string rough = fmt::format("{:.2g}", factor);
  return rough == "1" ? fmt::format("{:.3g}", factor) : rough;
}

/// True if covariances of a kind are too small by more than words say.
bool is_notably_too_certain(const KindScale& kind) {
  return kind.is_too_certain && in_words(factor_of(kind)) != "1";
}

/// True if covariances of a kind of measurements are too small.
bool is_too_certain(const GoodnessOfFit& fit) {
  return std::ranges::any_of(fit.kinds, is_notably_too_certain);
}

/// True for a kind that is of the fixes of --gps, which are priors.
bool is_of_fixes(const KindScale& kind, const RunReport& run_report) {
  return run_report.gps && kind.kind == PartKind::kPrior;
}

/// The factors by which typical residuals are too large or, if none is, chi2 as a whole.
std::string scales_in_words(const RunReport& run_report) {
  const GoodnessOfFit& fit = run_report.figures.fit;
  std::vector<std::string> words;
  for (const KindScale& kind : fit.kinds) {
    if (!is_notably_too_certain(kind)) continue;
    const auto name = is_of_fixes(kind, run_report) ? std::string(kFix) : to_string(kind.kind);
    words.push_back(fmt::format("{} {} times", name, in_words(factor_of(kind))));
  }
  if (words.empty()) return fmt::format("chi2 as a whole is too large: {:.6g} over {} degrees of freedom", fit.chi2, fit.dof);
  return fmt::format("typical residuals are larger than the covariances say: {}", fmt::join(words, ", "));
}

/// The reason why a map is untested.
std::string why_untested(const RunReport& run_report) {
  if (run_report.figures.no_verdict) return run_report.figures.no_verdict->message;
  return run_report.options.verdict ? "nothing is measured twice" : "no verdict was asked for";
}

/// What --inflate takes for the kinds whose covariances are too small, on top of what it was given; all are 1 if there is none.
Inflation inflation_that_fits(const RunReport& run_report) {
  Inflation inflation;
  for (const KindScale& kind : run_report.figures.fit.kinds) {
    if (!is_notably_too_certain(kind) || is_of_fixes(kind, run_report)) continue;
    double& factor = inflation.*inflation_of_kind(kind.kind);
    factor = std::max(factor, factor_of(kind));
  }
  if (inflation == Inflation{}) return inflation;
  for (const auto& [name, factor] : kInflatedKinds) inflation.*factor *= run_report.conventions.inflation.*factor;
  return inflation;
}

/// The command that takes covariances to be as large as the residuals of their kind are: "`mapjoin run LOG --inflate
/// closure=8.32`", by their inflation_that_fits(). Empty if that is none, and for weights that are not those of the input.
std::string remedy_of_scales(const RunReport& run_report, const Inflation& inflation) {
  if (inflation == Inflation{} || run_report.conventions.covariance != Covariance::kOriginal) return "";
  std::vector<std::string> words;
  for (const auto& [name, factor] : kInflatedKinds) {
    if (inflation.*factor != 1.0) words.push_back(fmt::format("{}={:.4g}", name, inflation.*factor));
  }
  return fmt::format("`mapjoin {} --inflate {}`", inflation.maps != 1.0 ? "join MAPS" : "run LOG", fmt::join(words, ","));
}

/// The command that looks for wrong measurements of the kind that is the most out of line; empty where none would look at it.
std::string_view remedy_of_misfits(const RunReport& run_report) {
  if (run_report.misfits.empty()) return "";
  switch (run_report.misfits.front().misfit.kind) {
    case PartKind::kClosure:
    case PartKind::kObservation:
      return "`mapjoin run LOG --robust`";
    case PartKind::kOdometry:
      return "`mapjoin run LOG --robust=all`";
    case PartKind::kMapFeature:
      return "`mapjoin join MAPS --robust`";
    case PartKind::kPrior:
      return run_report.gps ? "`mapjoin run LOG --gps FILE --robust`" : "";
    case PartKind::kLocalMap:
      break;
  }
  return "";
}

}  // namespace

std::string remedy_in_words(const RunReport& run_report) {
  const GoodnessOfFit& fit = run_report.figures.fit;
  const bool is_robust = run_report.robust.has_value();
  const Inflation inflation = inflation_that_fits(run_report);
  const std::string inflating = remedy_of_scales(run_report, inflation);
  const bool goes_by_scale = inflation.maps != 1.0;  // --robust does, of local maps
  if (is_robust && is_too_certain(fit) && !goes_by_scale) {
    return fmt::format(
        "--robust judges by covariances that are too small: what is right may be rejected, too; without it the "
        "verdict says how much larger residuals are than these say{}",
        inflating.empty() ? "" : ", and gives the --inflate to add");
  }
  const std::string_view rejecting = is_robust ? "" : remedy_of_misfits(run_report);
  if (!inflating.empty() && !rejecting.empty() && !fit.is_complete) {
    return fmt::format(
        "either what is named is wrong, and makes others look so: then {} leaves out little; or it leaves out "
        "much, as the covariances of a kind are too small, which {} makes as large as the residuals are",
        rejecting, inflating);
  }
  if (!inflating.empty()) {
    return inflating + " takes standard deviations to be as large as the residuals are, for all measurements of a kind";
  }
  if (rejecting.empty() || is_too_certain(fit)) return "";
  return fmt::format(
      "either what is named is wrong, or what contradicts it: {} looks for what contradicts the most, and leaves "
      "it out",
      rejecting);
}

std::string name_of(const NamedMisfit& misfit) {
  const std::string to = std::visit([](const auto& id) { return to_string(id); }, misfit.to);
  const std::string from = misfit.from ? to_string(*misfit.from) : "the World";
  switch (misfit.misfit.kind) {
    case PartKind::kObservation:
      return fmt::format("observation of {} from {}", to, from);
    case PartKind::kPrior:
      return misfit.lines.empty() ? "prior of " + to
                                  : fmt::format("{} of line {} at {}", kFix, fmt::join(misfit.lines, " or "), to);
    case PartKind::kMapFeature:
      return fmt::format("{} of the local map from {}", to, from);
    default:
      return fmt::format("{} from {} to {}", to_string(misfit.misfit.kind), from, to);
  }
}

std::string in_words(const NamedMisfit& misfit) {
  return fmt::format("{} (chi2 {:.4g} over {})", name_of(misfit), misfit.misfit.chi2, plural(misfit.misfit.rows, "row"));
}

std::string verdict_in_words(const RunReport& run_report) {
  const GoodnessOfFit& fit = run_report.figures.fit;
  switch (fit.verdict) {
    case Verdict::kUntested:
      return "untested: " + why_untested(run_report);
    case Verdict::kUnconverged:
      return "UNCONVERGED: the residuals tell nothing yet";
    case Verdict::kFits:
      return fmt::format("fits: nothing is out of line among {} tested", plural(fit.parts, "measurement"));
    case Verdict::kMisfit:
      break;
  }
  if (run_report.misfits.empty()) return "MISFIT: " + scales_in_words(run_report);
  const std::size_t others = run_report.misfits.size() - 1;
  return fmt::format("MISFIT: {}{} out of line with the rest{}", in_words(run_report.misfits.front()),
                     others > 0 ? fmt::format(" and {} more are", others) : " is",
                     fit.is_complete ? "" : fmt::format("; more may show without {}", others > 0 ? "them" : "it"));
}

void add_verdict(const RunReport& run_report, Lines& lines) {
  lines.add("verdict", verdict_in_words(run_report));
  const auto& misfits = run_report.misfits;
  for (std::size_t k = 1; k < std::min(misfits.size(), kMostShown); ++k) lines.add("", in_words(misfits[k]));
  if (!misfits.empty() && is_too_certain(run_report.figures.fit)) lines.add("", scales_in_words(run_report));
}

Findings verdict_findings(const RunReport& run_report) {
  const GoodnessOfFit& fit = run_report.figures.fit;
  if (fit.verdict == Verdict::kUntested) {
    return {{FindingLevel::kNote, "untested", "nothing here can be tested: " + why_untested(run_report), {}}};
  }
  if (fit.verdict != Verdict::kMisfit) return {};
  Places misfits;
  for (const NamedMisfit& misfit : run_report.misfits) misfits.add(in_words(misfit));
  const std::string out_of_line = fmt::format("out of line with the rest: {} of {} measurements{}", misfits.count, fit.parts,
                                              fit.is_complete ? "" : ", and perhaps others, which show without these");
  Findings findings;
  add_if_any(findings, {FindingLevel::kWarning, "misfit", out_of_line, misfits});
  if (findings.empty() || is_too_certain(fit)) {
    const bool is_sure = misfits.count == 0 || fit.is_complete;
    const std::string remedy = is_sure ? remedy_of_scales(run_report, inflation_that_fits(run_report)) : "";
    const std::string inflated = remedy.empty() ? "" : "; " + remedy + " takes standard deviations to be so much larger";
    findings.push_back({FindingLevel::kWarning, "misfit", scales_in_words(run_report) + inflated, {}});
  }
  return findings;
}

Json verdict_of(const RunReport& run_report) {
  const GoodnessOfFit& fit = run_report.figures.fit;
  Json kinds = Json::array();
  for (const KindScale& kind : fit.kinds) {
    kinds.push_back({{"kind", kind.kind},
                     {"parts", kind.parts},
                     {"confirmed", kind.confirmed},
                     {"scale", kind.scale},
                     {"too_certain", kind.is_too_certain}});
  }
  Json misfits = Json::array();
  for (const NamedMisfit& misfit : run_report.misfits) {
    misfits.push_back({{"kind", misfit.misfit.kind},
                       {"from", misfit.from},
                       {"to", std::visit([](const auto& id) { return Json(id); }, misfit.to)},
                       {"lines", misfit.lines},
                       {"chi2", misfit.misfit.chi2},
                       {"rows", misfit.misfit.rows},
                       {"probability", misfit.misfit.probability}});
  }
  const bool is_tested = fit.verdict == Verdict::kFits || fit.verdict == Verdict::kMisfit;
  return {{"verdict", run_report.is_joined ? Json(fit.verdict) : Json()},
          {"fit", if_known(is_tested, {{"parts", fit.parts},
                                       {"chi2", fit.chi2},
                                       {"dof", fit.dof},
                                       {"probability", fit.probability},
                                       {"complete", fit.is_complete},
                                       {"kinds", kinds}})},
          {"misfits", misfits}};
}

std::string misfits_as_csv(const RunReport& run_report) {
  std::string text = "kind,from_session,from,to_session,to,chi2,rows,probability\n";
  for (const auto& [misfit, from, to, lines] : run_report.misfits) {
    TextLine line(',');
    line.add(to_string(misfit.kind));
    line.add(from ? session_text(*from) : "").add(from ? key_text(from->key) : "");
    std::visit([&line](const auto& id) { line.add(session_text(id)).add(key_text(id.key)); }, to);
    line.add(misfit.chi2).add(misfit.rows).add(misfit.probability).append_to(text);
  }
  return text;
}

}  // namespace mapjoin::apps
