// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Numbers of things in sentences.

#include <cstddef>
#include <string>

namespace mapjoin {

/// "1 edge", "2 edges".
inline std::string counted(std::size_t count, const std::string& thing) {
  return std::to_string(count) + " " + thing + (count == 1 ? "" : "s");
}

}  // namespace mapjoin
