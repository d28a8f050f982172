// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Whether a map fits its measurements, and what `--robust` left out for that, for people and for other programs.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>

namespace mapjoin::apps {

/// The kind of a prior that is a fix of --gps, in words and among what was rejected.
inline constexpr std::string_view kFix = "fix";

/// The session of a name in a table; features have none.
inline std::string session_text(const PoseId& id) {
  return std::to_string(id.session);
}
inline std::string session_text(const FeatureId&) {
  return "";
}

/// "closure from pose 17 to pose 2034", "observation of feature 9 from pose 4", "feature 9 of the local map from pose 0", "fix
/// of line 3 at pose 2", …
std::string name_of(const NamedMisfit& misfit);

/// The same with its chi2 and rows.
std::string in_words(const NamedMisfit& misfit);

/// By how much typical residuals are too large, or chi2 as a whole where these are not.
std::string scales_in_words(const RunReport& run_report);
/// Why a map is untested.
std::string why_untested(const RunReport& run_report);

/// The verdict and its reason, in one line.
std::string verdict_in_words(const RunReport& run_report);

/// The line of the verdict, then one for each of the first misfits.
void add_verdict(const RunReport& run_report, Lines& lines);

/// The keys of the report: `verdict`, `fit` and `misfits`.
Json verdict_of(const RunReport& run_report);

/// A line per misfit below one of names: kind,from_session,from,to_session,to,chi2,rows,probability. The World and features
/// have no session, the World no number.
std::string misfits_as_csv(const RunReport& run_report);

/// How many closures and observations were left out, of how many, in one line.
std::string rejected_in_words(const RunReport& run_report);

/// The key `robust` of the report: null where nothing was to be left out.
Json robust_of(const RunReport& run_report);

/// A line for each below one of names: kind,from,to,chi2,probability,why,from_session,to_session. Features have no session, and
/// a fix is from the line of its file.
std::string rejected_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
