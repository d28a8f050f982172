// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A run for other programs, as JSON by the schema of docs/report.md, and for people, as a summary.

#include <apps/report/run_report.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace mapjoin::apps {

inline constexpr int kReportSchemaVersion = 1;

/// What every report begins with: version, command, and what the input is.
nlohmann::ordered_json report_head(const RunReport& run_report);

/// An object as it is written: indented, and what is not UTF-8 replaced.
std::string text_of(const nlohmann::ordered_json& json);

/// One JSON object and a newline. Every key is always there; what was not done is null.
std::string report(const RunReport& run_report);

Expected<void> write_report(const RunReport& run_report, const std::filesystem::path& path);

/// About ten aligned lines: what was read, what each stage came to, chi2 with its meaning, times, files; then what to know of
/// the data.
std::string summary(const RunReport& run_report);

/// "2D, 6899 poses, 299 features, …"
std::string counts_in_words(const RunReport& run_report);
/// In what sense chi2 is meant.
std::string conventions_in_words(const Conventions& conventions, int dimension);
/// What of the input a reader may not expect: repeated edges, repaired matrices, observations left out.
std::vector<std::string> remarks(const RunReport& run_report);

}  // namespace mapjoin::apps
