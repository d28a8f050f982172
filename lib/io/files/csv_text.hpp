// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Comma-separated tables whose first line names their columns, as a TextScanner takes them.

#include <algorithm>
#include <mapjoin/io/files/text_scanner.hpp>
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
inline std::vector<std::string> csv_columns(std::string_view csv) {
  std::vector<std::string> columns;
  TextScanner text("", csv);
  if (!text.next_line()) return columns;
  for (std::string_view line = text.word();;) {
    const std::size_t comma = std::min(line.find(','), line.size());
    columns.emplace_back(line.substr(0, comma));
    if (comma == line.size()) return columns;
    line.remove_prefix(comma + 1);
  }
}

inline bool has_column(const std::vector<std::string>& columns, std::string_view name) {
  return std::ranges::find(columns, name) != columns.end();
}

}  // namespace mapjoin
