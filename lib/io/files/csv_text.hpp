// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Comma-separated tables whose first line names their columns, as a TextScanner takes them.

#include <fmt/format.h>

#include <algorithm>
#include <cstdint>
#include <initializer_list>
#include <limits>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// What stands for a cell that is empty: no number.
inline constexpr std::string_view kEmptyCell = "(empty)";

/// The text with blanks for commas and a word in every cell. Places are as they were, on a line up to its first empty cell.
inline std::string with_blanks(std::string_view csv) {
  std::string blanks;
  blanks.reserve(csv.size());
  bool is_empty = true;   // the cell so far
  bool is_single = true;  // and the first of its line
  const auto end_cell = [&] {
    if (is_empty) blanks += kEmptyCell;
    is_empty = true;
  };
  for (const char c : csv) {
    const bool ends_line = c == '\n' || c == '\r';
    if (c == ',' || (ends_line && !is_single)) end_cell();
    if (c == ',' || ends_line) is_single = ends_line;
    is_empty = is_empty && (c == ',' || ends_line || c == ' ' || c == '\t');
    blanks += c == ',' ? ' ' : c;
  }
  if (!is_single) end_cell();
  return blanks;
}

/// The next word as the session of a pose.
inline std::uint32_t read_session(TextScanner& text) {
  const std::uint64_t session = text.key();
  if (session > std::numeric_limits<std::uint32_t>::max()) text.reject("a session is a number below 2^32");
  return static_cast<std::uint32_t>(session);
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

/// Bad input where one of these names is that of several columns.
inline Expected<void> check_named_once(const std::vector<std::string>& columns, std::initializer_list<const char*> names,
                                       const std::string& file) {
  const auto twice = std::ranges::find_if(names, [&](const char* name) { return std::ranges::count(columns, name) > 1; });
  return twice == names.end() ? Expected<void>()
                              : bad_input(fmt::format("{}:1: names the column {} more than once", file, *twice));
}

}  // namespace mapjoin
