// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The lines of a table that a run wrote, as a TextScanner takes them.

#include <apps/exit_code.hpp>
#include <filesystem>
#include <mapjoin/io/files/csv_text.hpp>
#include <mapjoin/io/files/file_bytes.hpp>
#include <mapjoin/io/files/text_scanner.hpp>
#include <string>
#include <string_view>

namespace mapjoin::apps {

/// Calls read(line, first word of the header) for each line below the header of a CSV file, at its first word.
template <typename Read>
void each_line(const std::filesystem::path& file, Read&& read) {
  const FileBytes bytes = FileBytes::read(file).value();
  const std::string text = with_blanks(bytes.view());
  TextScanner line(file.string(), text);
  line.next_line();
  const std::string header(line.word());
  demand(line.each_line([&] {
    read(line, header);
    while (!line.at_end_of_line()) line.word();
  }));
}

}  // namespace mapjoin::apps
