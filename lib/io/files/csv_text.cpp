// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/text_scanner.hpp>

namespace mapjoin {

std::vector<std::string> csv_columns(std::string_view csv) {
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

}  // namespace mapjoin
