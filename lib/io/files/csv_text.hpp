// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Comma-separated tables whose first line names their columns, as a TextScanner takes them.

#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// The text with blanks for commas, of the same places. A cell that is empty is then missing from its line.
inline std::string with_blanks(std::string_view csv) {
  std::string blanks(csv);
  std::ranges::replace(blanks, ',', ' ');
  return blanks;
}

/// The columns that the first line with a word names.
std::vector<std::string> csv_columns(std::string_view csv);

inline bool has_column(const std::vector<std::string>& columns, std::string_view name) {
  return std::ranges::find(columns, name) != columns.end();
}

}  // namespace mapjoin
