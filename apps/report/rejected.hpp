// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `--robust` left out, for people and for other programs.

#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>

namespace mapjoin::apps {

/// How many closures and observations were left out, of how many, in one line.
std::string rejected_in_words(const RunReport& run_report);

/// The key `robust` of the report: null where nothing was to be left out.
Json robust_of(const RunReport& run_report);

/// A line for each below one of names: kind,from,to,chi2,probability,why,from_session,to_session. Features have no session, and
/// a fix is from the line of its file.
std::string rejected_as_csv(const RunReport& run_report);

}  // namespace mapjoin::apps
