// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The kinds of lines that readers leave out by their tags, in a number and a length that a summary can tell.

#include <mapjoin/io/files/text_scanner.hpp>
#include <mapjoin/model/log.hpp>
#include <string>
#include <string_view>

namespace mapjoin {

/// The kind of the lines of a tag in Log::skipped.
inline std::string lines_of(std::string_view tag) {
  return shortened(tag) + " lines";
}

/// Counts the lines of all tags but the first twenty, by their names, as "other lines".
inline void count_others_together(SkipCounts& skipped) {
  constexpr int kMostTags = 20;
  int tags = 0;
  std::int64_t others = 0;
  std::erase_if(skipped, [&](const auto& kind) {
    const bool is_other = kind.first.ends_with(" lines") && ++tags > kMostTags;
    if (is_other) others += kind.second;
    return is_other;
  });
  if (others > 0) skipped["other lines"] += others;
}

}  // namespace mapjoin
