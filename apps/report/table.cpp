// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <apps/console.hpp>
#include <apps/report/table.hpp>
#include <boost/algorithm/string/replace.hpp>
#include <cmath>

namespace mapjoin::apps {
namespace {

std::string quoted(const std::string& text) {
  if (text.find_first_of(",\"\n") == std::string::npos) return text;
  return "\"" + boost::replace_all_copy(text, "\"", "\"\"") + "\"";
}

std::string exact(const Cell& cell) {
  if (cell.is_string()) return quoted(cell.get<std::string>());
  if (cell.is_number_float()) return std::isfinite(cell.get<double>()) ? fmt::format("{}", cell.get<double>()) : "";
  return cell.is_null() ? "" : cell.dump();
}

template <typename Texts>
std::string csv_line(const Texts& texts) {
  return fmt::format("{}\n", fmt::join(texts, ","));
}

/// A column as lines of a terminal: those of the heading, as many as the tallest one has, then one per row.
struct Strip {
  std::vector<std::string> lines;
  std::size_t heading_height = 0;
  std::size_t width = 0;
  bool to_the_right = false;
};

Strip strip_of(const ReportTable& table, std::size_t column) {
  const Column& of = table.columns[column];
  std::vector<std::string> cells;
  std::size_t width = 0;
  for (const Row& row : table.rows) {
    cells.push_back(shown(row.cells[column], of));
    width = std::max(width, cells.back().size());
  }
  for (const std::string& word : wrapped(of.heading, 0)) width = std::max(width, word.size());
  Strip strip{wrapped(of.heading, width), 0, width, is_numeric(table, column)};
  strip.heading_height = strip.lines.size();
  strip.lines.insert(strip.lines.end(), cells.begin(), cells.end());
  return strip;
}

}  // namespace

Row& ReportTable::add(const Json& object, RowKind kind) {
  Row& row = rows.emplace_back();
  row.kind = kind;
  for (const Column& column : columns) {
    const Json::json_pointer at(column.path);
    Json value = object.contains(at) ? object.at(at) : Json();
    row.cells.push_back(column.scale == 1.0 || value.is_null() ? value : Json(column.scale * value.get<double>()));
  }
  return row;
}

std::string shown(const Cell& cell, const Column& column) {
  if (cell.is_number_float()) return fmt::format("{:.{}g}", cell.get<double>(), column.digits);
  return cell.is_string() ? cell.get<std::string>() : exact(cell);
}

bool is_numeric(const ReportTable& table, std::size_t column) {
  return std::none_of(table.rows.begin(), table.rows.end(), [&](const Row& row) { return row.cells[column].is_string(); });
}

std::string aligned(const ReportTable& table) {
  std::vector<Strip> strips;
  std::size_t tallest = 0;
  for (std::size_t c = 0; c < table.columns.size(); ++c) {
    strips.push_back(strip_of(table, c));
    tallest = std::max(tallest, strips.back().heading_height);
  }
  for (Strip& strip : strips) strip.lines.insert(strip.lines.begin(), tallest - strip.heading_height, "");
  std::string text;
  for (std::size_t k = 0; k < tallest + table.rows.size(); ++k) {
    std::string line;
    for (const Strip& strip : strips) {
      line += strip.to_the_right ? fmt::format("{:>{}}  ", strip.lines[k], strip.width)
                                 : fmt::format("{:<{}}  ", strip.lines[k], strip.width);
    }
    text += line.erase(line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string csv(const ReportTable& table) {
  std::vector<std::string> texts;
  for (const Column& column : table.columns) texts.push_back(quoted(column.key));
  std::string text = csv_line(texts);
  for (const Row& row : table.rows) {
    std::transform(row.cells.begin(), row.cells.end(), texts.begin(), exact);
    text += csv_line(texts);
  }
  return text;
}

}  // namespace mapjoin::apps
