// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The report for other programs: JSON by the schema of docs/report.md.

#include <apps/report/run_report.hpp>
#include <filesystem>
#include <nlohmann/json_fwd.hpp>
#include <string>

namespace mapjoin::apps {

inline constexpr int kReportSchemaVersion = 1;

/// What every report begins with: version, command, and what the input is.
nlohmann::ordered_json report_head(const Account& account);

/// An object as it is written: indented, and what is not UTF-8 replaced.
std::string text_of(const nlohmann::ordered_json& json);

/// One JSON object and a newline. Every key is always there; what was not done is null.
std::string report(const Account& account);

Expected<void> write_report(const Account& account, const std::filesystem::path& path);

}  // namespace mapjoin::apps
