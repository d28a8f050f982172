// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A table of words and numbers: aligned for a terminal, or as CSV.

#include <cstdint>
#include <string>
#include <variant>
#include <vector>

namespace mapjoin::apps {

using Cell = std::variant<std::monostate, std::string, std::int64_t, double>;

struct Column {
  std::string key;      ///< In CSV.
  std::string heading;  ///< For people.
  int digits = 4;       ///< Of a number, for people: significant ones.
};

/// What a row is to be told from others by, where colours can.
enum class RowKind : std::uint8_t { kPlain, kGood, kBad };

struct Row {
  std::vector<Cell> cells;  ///< By column.
  RowKind kind = RowKind::kPlain;
};

struct Table {
  std::vector<Column> columns;
  std::vector<Row> rows;
};

/// A cell for people; nothing where it is empty.
std::string shown(const Cell& cell, const Column& column);
/// Whether all cells of a column are numbers or empty.
bool is_numeric(const Table& table, std::size_t column);

/// Lines of equal columns, two blanks apart; numbers to the right. The heading's words stand below each other.
std::string aligned(const Table& table);
/// One line per row below a line of keys, by RFC 4180; numbers so that they are read back as they are.
std::string csv(const Table& table);

}  // namespace mapjoin::apps
