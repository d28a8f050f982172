// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tables for a terminal.

#include <string>
#include <string_view>
#include <vector>

namespace mapjoin::apps {

/// Rows of cells, the heading first, in columns as wide as their widest cell. `sides` has a letter per column: `l` for words,
/// `r` for numbers.
std::string text_table(const std::vector<std::vector<std::string>>& rows, std::string_view sides);

}  // namespace mapjoin::apps
