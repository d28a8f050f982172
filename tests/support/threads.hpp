// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How many threads this process has, whoever started them.

#include <filesystem>
#include <iterator>

namespace mapjoin::testing {

inline std::ptrdiff_t threads_of_this_process() {
  return std::distance(std::filesystem::directory_iterator("/proc/self/task"), {});
}

}  // namespace mapjoin::testing
