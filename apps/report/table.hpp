// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A table of words and numbers: aligned for a terminal, or as CSV; its rows can be objects of a report.

#include <apps/report/json.hpp>
#include <cstdint>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// A word, a number, or null for nothing.
using Cell = Json;

struct Column {
  std::string key;               ///< In CSV.
  std::string heading;           ///< For people.
  int digits = 4;                ///< Significant ones of a number, for people.
  std::string path = "/" + key;  ///< Where an object has its value, as a JSON pointer.
  double scale = 1.0;            ///< What such a value is multiplied by.
};

/// What a row is to be told from others by, where colours can.
enum class RowKind : std::uint8_t { kPlain, kGood, kBad };

struct Row {
  std::vector<Cell> cells;  ///< By column.
  RowKind kind = RowKind::kPlain;
};

struct ReportTable {
  std::vector<Column> columns;
  std::vector<Row> rows;

  /// A row of what each column names in the object; null where that is not there.
  Row& add(const Json& object, RowKind kind = RowKind::kPlain);
};

/// A cell for people; nothing where it is null.
std::string shown(const Cell& cell, const Column& column);
/// Whether all cells of a column are numbers or null.
bool is_numeric(const ReportTable& table, std::size_t column);

/// Lines of equal columns, two blanks apart; numbers to the right. The heading's words stand below each other.
std::string aligned(const ReportTable& table);
/// One line per row below a line of keys, by RFC 4180; numbers so that they are read back as they are, nothing where they are
/// not finite.
std::string csv(const ReportTable& table);

}  // namespace mapjoin::apps
