// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/report/table.hpp>
#include <iterator>
#include <sstream>

namespace mapjoin::apps {
namespace {

/// Words that together are no wider than the widest cell or word stay on one line.
std::vector<std::string> heading_lines(const std::string& heading, std::size_t width) {
  std::istringstream stream(heading);
  const std::vector<std::string> words{std::istream_iterator<std::string>(stream), {}};
  for (const std::string& word : words) width = std::max(width, word.size());
  std::vector<std::string> lines;
  for (const std::string& word : words) {
    if (!lines.empty() && lines.back().size() + 1 + word.size() <= width) {
      lines.back() += " " + word;
    } else {
      lines.push_back(word);
    }
  }
  return lines;
}

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  std::string out = "\"";
  for (const char c : text) out += c == '"' ? "\"\"" : std::string(1, c);
  return out + "\"";
}

std::string exact(const Cell& cell) {
  if (const auto* text = std::get_if<std::string>(&cell)) return quoted(*text);
  if (const auto* whole = std::get_if<std::int64_t>(&cell)) return fmt::format("{}", *whole);
  if (const auto* number = std::get_if<double>(&cell)) return fmt::format("{}", *number);
  return "";
}

/// A column as the lines of a terminal: those of the heading, then one per row.
struct Strip {
  std::vector<std::string> heading;
  std::vector<std::string> cells;
  std::size_t width = 0;
  bool to_the_right = false;
};

Strip strip_of(const Table& table, std::size_t column) {
  Strip strip;
  strip.to_the_right = is_numeric(table, column);
  for (const Row& row : table.rows) {
    strip.cells.push_back(shown(row.cells[column], table.columns[column]));
    strip.width = std::max(strip.width, strip.cells.back().size());
  }
  strip.heading = heading_lines(table.columns[column].heading, strip.width);
  for (const std::string& line : strip.heading) strip.width = std::max(strip.width, line.size());
  return strip;
}

std::string line_of(const std::vector<Strip>& strips, const std::vector<std::string>& texts) {
  std::string line;
  for (std::size_t c = 0; c < strips.size(); ++c) {
    if (c > 0) line += "  ";
    line += strips[c].to_the_right ? fmt::format("{:>{}}", texts[c], strips[c].width)
                                   : fmt::format("{:<{}}", texts[c], strips[c].width);
  }
  line.erase(line.find_last_not_of(' ') + 1);
  return line + "\n";
}

}  // namespace

std::string shown(const Cell& cell, const Column& column) {
  if (const auto* number = std::get_if<double>(&cell)) return fmt::format("{:.{}g}", *number, column.digits);
  if (const auto* text = std::get_if<std::string>(&cell)) return *text;
  return exact(cell);
}

bool is_numeric(const Table& table, std::size_t column) {
  return std::none_of(table.rows.begin(), table.rows.end(),
                      [&](const Row& row) { return std::holds_alternative<std::string>(row.cells[column]); });
}

std::string aligned(const Table& table) {
  std::vector<Strip> strips;
  std::size_t tallest = 0;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    strips.push_back(strip_of(table, c));
    tallest = std::max(tallest, strips.back().heading.size());
  }
  std::string text;
  std::vector<std::string> texts(strips.size());
  for (std::size_t line = 0; line < tallest; ++line) {
    for (std::size_t c = 0; c < strips.size(); ++c) {
      const std::size_t blank = tallest - strips[c].heading.size();
      texts[c] = line < blank ? "" : strips[c].heading[line - blank];
    }
    text += line_of(strips, texts);
  }
  for (std::size_t row = 0; row < table.rows.size(); ++row) {
    for (std::size_t c = 0; c < strips.size(); ++c) texts[c] = strips[c].cells[row];
    text += line_of(strips, texts);
  }
  return text;
}

std::string csv(const Table& table) {
  std::string text;
  for (const Column& column : table.columns) text += fmt::format("{}{}", text.empty() ? "" : ",", quoted(column.key));
  text += "\n";
  for (const Row& row : table.rows) {
    for (std::size_t c = 0; c < row.cells.size(); ++c) text += fmt::format("{}{}", c > 0 ? "," : "", exact(row.cells[c]));
    text += "\n";
  }
  return text;
}

}  // namespace mapjoin::apps
