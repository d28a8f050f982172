// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A run for other programs, as JSON by the schema of docs/report.md, and for people, as a summary.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>
#include <string_view>

namespace mapjoin::apps {

inline constexpr int kReportSchemaVersion = 1;

/// What every report begins with: version, command, what the input is, and how much of it was left out.
Json report_head(const RunReport& run_report);

/// An object as it is written: indented, and what is not UTF-8 replaced.
std::string text_of(const Json& json);

/// One JSON object and a newline. Every key is always there; what was not done is null.
std::string report(const RunReport& run_report);

/// About ten aligned lines: what was read, what each stage came to, chi2 with its meaning, times, files; then what to know of
/// the data.
std::string summary(const RunReport& run_report);

/// "2D, 6899 poses, 299 features, …"
std::string counts_in_words(const RunReport& run_report);
/// What holds the map.
std::string gauge_in_words(const RunReport& run_report);
/// In what sense chi2 is meant.
std::string conventions_in_words(const Conventions& conventions, int dimension);

/// Lines of a summary: the input with its counts and how much of it was left out, its convention, and what a reader may not
/// expect of it: repeated edges, repaired matrices, observations left out.
void add_input(const RunReport& run_report, Lines& lines, std::string_view name = "input");
void add_convention(const RunReport& run_report, Lines& lines);
void add_notes(const RunReport& run_report, Lines& lines);

}  // namespace mapjoin::apps
