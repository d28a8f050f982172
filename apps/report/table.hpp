// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A table of words and numbers: aligned for a terminal, or as CSV; its rows can be objects of a report.

#include <apps/report/json.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// A word, a number, or null.
using Cell = Json;

struct Column {
  std::string key;               ///< Heading in CSV.
  std::string heading;           ///< Heading for people.
  int digits = 4;                ///< Significant digits of a number, for people.
  std::string path = "/" + key;  ///< Place of the value in an object, as a JSON pointer.
  double scale = 1.0;            ///< Factor for such a value.
};

/// The kind of a row, told apart by colours.
enum class RowKind : std::uint8_t { kPlain, kGood, kBad };

struct Row {
  std::vector<Cell> cells;  ///< Cells by column.
  RowKind kind = RowKind::kPlain;
};

struct ReportTable {
  std::vector<Column> columns;
  std::vector<Row> rows;

  /// Adds a row of the values that the columns name in the object; null if missing.
  Row& add(const Json& object, RowKind kind = RowKind::kPlain);
};

/// A cell as text for people; empty if it is null.
std::string shown(const Cell& cell, const Column& column);
/// True if all cells of a column are numbers or null.
bool is_numeric(const ReportTable& table, std::size_t column);

/// The table as aligned lines, columns two blanks apart, numbers to the right. Words of a heading stand below each other.
std::string aligned(const ReportTable& table);
/// The table as CSV (RFC 4180): a line of keys, then one per row; numbers so that they are read back as they are, empty if not
/// finite.
std::string csv(const ReportTable& table);

}  // namespace mapjoin::apps
