// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The summary for people.

#include <apps/report/run_report.hpp>
#include <string>

namespace mapjoin::apps {

/// About ten aligned lines: what was read, what each stage came to, chi2 with its meaning, times, files; then what to know of
/// the data.
std::string summary(const Account& account);

/// "2D, 6899 poses, 299 features, …"
std::string counts_in_words(const Account& account);
/// In what sense chi2 is meant.
std::string conventions_in_words(const Conventions& conventions, int dimension);
/// What of the input a reader may not expect: repeated edges, repaired matrices, observations left out.
std::vector<std::string> remarks(const Account& account);

}  // namespace mapjoin::apps
