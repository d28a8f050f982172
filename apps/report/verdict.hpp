// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The verdict on the fit of a map to its measurements, and the measurements that `--robust` rejected, for people and for other
// programs.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <mapjoin/check/checks.hpp>
#include <string>

namespace mapjoin::apps {

/// The name of the kind of a prior that is a fix of --gps, in words and in `rejected.csv`.
inline constexpr std::string_view kFix = "fix";

/// The session of a name in a table; empty for features.
inline std::string session_text(const PoseId& id) {
  return std::to_string(id.session);
}
inline std::string session_text(const FeatureId&) {
  return "";
}

/// What to do about a misfit, for a note: the commands that leave out what is wrong, or take covariances that are too small to
/// be as large as the residuals; empty if nothing helps.
std::string remedy_in_words(const RunReport& run_report);

/// The name of a misfit: "closure from pose 17 to pose 2034", "observation of feature 9 from pose 4", "feature 9 of the local
/// map from pose 0", "fix of line 3 at pose 2", …
std::string name_of(const NamedMisfit& misfit);

/// The name of a misfit with its chi2 and rows.
std::string in_words(const NamedMisfit& misfit);

/// The verdict and its reason, in one line.
std::string verdict_in_words(const RunReport& run_report);

/// Adds the line of the verdict, then one for each of the first misfits.
void add_verdict(const RunReport& run_report, Lines& lines);

/// The verdict as findings of a check: the misfits, the worst first, and covariances that are too small, or a chi2 that is too
/// large as a whole; or that nothing can be tested.
Findings verdict_findings(const RunReport& run_report);

/// The keys `verdict`, `fit` and `misfits` of the report.
Json verdict_of(const RunReport& run_report);

/// CSV with a line per misfit and the header kind,from_session,from,to_session,to,chi2,rows,probability. The World and features
/// have no session, the World no number.
std::string misfits_as_csv(const RunReport& run_report);

/// The numbers of rejected measurements by kind, each of how many, in one line.
std::string rejected_in_words(const RunReport& run_report);

/// What was rejected as a finding of a check, the least probable first; none if nothing was.
Findings rejected_findings(const RunReport& run_report);

/// The key `robust` of the report: null without --robust.
Json robust_of(const RunReport& run_report);

/// CSV with a line per rejected measurement and the header kind,from,to,chi2,probability,why,from_session,to_session. Features
/// have no session, and a fix is from the line of its file.
std::string rejected_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
