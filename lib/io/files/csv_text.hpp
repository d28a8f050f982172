// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Comma-separated tables whose first line names their columns, as a TextScanner takes them.

#include <fmt/format.h>

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <initializer_list>
#include <limits>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/error.hpp>
#include <string>
#include <string_view>
#include <vector>

namespace mapjoin {

/// The word that stands for an empty cell; it is no number.
inline constexpr std::string_view kEmptyCell = "(empty)";

/// The text with blanks for commas and kEmptyCell in empty cells; words keep their places on a line up to its first empty cell.
inline std::string with_blanks(std::string_view csv) {
  std::string blanks;
  blanks.reserve(csv.size());
  bool is_empty = true;   // The current cell has only blanks so far.
  bool is_single = true;  // The current line has only one cell so far.
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

/// The text of a table as with_blanks() gives it, with `_` for blanks between words of a cell, such as a date and a time of
/// day, so that each cell is one word. A line without commas stays as it is.
inline std::string cells_as_words(std::string_view csv) {
  std::string table(csv);
  for (std::size_t begin = 0, end = 0; begin < table.size(); begin = end + 1) {
    end = std::min(table.find('\n', begin), table.size());
    if (csv.substr(begin, end - begin).find(',') == csv.npos) continue;
    bool has_word = false;       // the current cell
    std::size_t behind = begin;  // the character behind its last word
    for (std::size_t at = begin; at < end; ++at) {
      const char c = table[at];
      if (c == ' ' || c == '\t' || c == '\r') continue;
      if (c == '#' && (behind < at || !has_word)) break;  // a comment
      if (has_word && c != ',') std::fill(table.begin() + std::ptrdiff_t(behind), table.begin() + std::ptrdiff_t(at), '_');
      has_word = c != ',';
      behind = at + 1;
    }
  }
  return with_blanks(table);
}

/// Reads the next word as the session of a pose.
inline std::uint32_t read_session(TextScanner& text) {
  const std::uint64_t session = text.key();
  if (session > std::numeric_limits<std::uint32_t>::max()) text.reject("a session is a number below 2^32");
  return static_cast<std::uint32_t>(session);
}

/// The columns that the first line with a word names, without the blanks and the quotation marks around them.
inline std::vector<std::string> csv_columns(std::string_view csv) {
  std::vector<std::string> columns;
  TextScanner text("", csv);
  if (!text.next_line()) return columns;
  columns.emplace_back();
  const auto add = [&](std::string_view part) {
    if (!columns.back().empty() && !part.empty()) columns.back() += ' ';
    columns.back() += part;
  };
  while (!text.at_end_of_line()) {
    std::string_view word = text.word();
    for (std::size_t comma; (comma = word.find(',')) != word.npos; word.remove_prefix(comma + 1)) {
      add(word.substr(0, comma));
      columns.emplace_back();
    }
    add(word);
  }
  for (std::string& name : columns) {
    if (name.size() >= 2 && name.front() == '"' && name.back() == '"') name = name.substr(1, name.size() - 2);
  }
  return columns;
}

/// The place of the line of csv_columns(), for messages: `file:line`; without any, of the first one.
inline std::string header_place(std::string_view csv, const std::string& file) {
  TextScanner text("", csv);
  return fmt::format("{}:{}", file, text.next_line() ? text.place().line : 1);
}

/// Calls read(columns, row) at the first word of each line below the header of a table. Bad input as FileBytes::read() and
/// TextScanner::each_line() find it.
template <typename Read>
Expected<void> each_row(const std::filesystem::path& file, const Read& read) {
  return FileBytes::read(file).and_then([&](const FileBytes& bytes) {
    const std::vector<std::string> columns = csv_columns(bytes.view());
    const std::string text = cells_as_words(bytes.view());
    TextScanner row(file.string(), text);
    row.next_line();
    return row.each_line([&] {
      read(columns, row);
      while (!row.at_end_of_line()) row.word();
    });
  });
}

inline bool has_column(const std::vector<std::string>& columns, std::string_view name) {
  return std::ranges::find(columns, name) != columns.end();
}

/// Bad input if several columns have one of these names; `place` is the header_place().
inline Expected<void> check_named_once(const std::vector<std::string>& columns, std::initializer_list<const char*> names,
                                       const std::string& place) {
  const auto twice = std::ranges::find_if(names, [&](const char* name) { return std::ranges::count(columns, name) > 1; });
  return twice == names.end() ? Expected<void>()
                              : bad_input(fmt::format("{}: names the column {} more than once", place, *twice));
}

}  // namespace mapjoin
