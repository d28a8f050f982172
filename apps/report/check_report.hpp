// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What `mapjoin check` found, for people and for programs.

#include <apps/report/run_report.hpp>
#include <cstdint>
#include <mapjoin/check/finding.hpp>
#include <mapjoin/check/fit.hpp>
#include <vector>

namespace mapjoin::apps {

/// At which map residuals are weighed.
enum class CheckedEstimate : std::uint8_t { kJoined, kFile, kNone };
constexpr auto enum_names(CheckedEstimate) {
  return std::to_array<EnumName<CheckedEstimate>>(
      {{CheckedEstimate::kJoined, "joined"}, {CheckedEstimate::kFile, "file"}, {CheckedEstimate::kNone, "none"}});
}

struct Checked {
  CheckedEstimate estimate = CheckedEstimate::kJoined;
  Findings findings;
  std::vector<KindFit> fits;  ///< Empty where residuals were not weighed.
  std::int64_t dof = 0;       ///< Of all of them together.

  /// How many findings are of this level or a graver one.
  std::int64_t count(FindingLevel least) const;
};

std::string check_summary(const RunReport& run_report, const Checked& checked);
std::string check_report(const RunReport& run_report, const Checked& checked);

}  // namespace mapjoin::apps
