// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A run as a report for other programs, in JSON by the schema of docs/report.md, and as a summary for people.

#include <apps/console.hpp>
#include <apps/report/json.hpp>
#include <apps/report/run_report.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

inline constexpr int kReportSchemaVersion = 1;

/// The beginning of every report: version, command, the input, and how much of it was left out.
Json report_head(const RunReport& run_report);

/// An object as text: indented, with invalid UTF-8 replaced.
std::string text_of(const Json& json);

/// The report, one JSON object and a newline. Every key is always there, with null for results that were not computed.
std::string report(const RunReport& run_report);

/// The summary, about ten aligned lines: the input, the outcome of each stage, chi2 with its meaning, times, files; then notes
/// on the data.
std::string summary(const RunReport& run_report);

/// The counts in words: "2D, 6899 poses, 299 features, …"
std::string counts_in_words(const RunReport& run_report);
/// The gauge in words: anchored poses, priors or fixes.
std::string gauge_in_words(const RunReport& run_report);
/// What was left out of a log in words: "left out: VERTEX_CAM (3)"; empty if nothing was.
std::string left_out_in_words(const SkipCounts& skipped);
/// The conventions of chi2 in words.
std::string conventions_in_words(const Conventions& conventions, int dimension);

/// Notes on the data and on the result: what was repaired or left out while the input was read, and what one may not expect, as
/// repeated edges.
std::vector<std::string> notes_of(const RunReport& run_report);

/// Adds lines of a summary: the input with its counts and how much of it was left out; its convention; notes on what was
/// repaired or left out while it was read; all of notes_of().
void add_input(const RunReport& run_report, Lines& lines, std::string_view name = "input");
void add_convention(const RunReport& run_report, Lines& lines);
void add_reading_notes(const RunReport& run_report, Lines& lines);
void add_notes(const RunReport& run_report, Lines& lines);

}  // namespace mapjoin::apps
