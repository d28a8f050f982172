// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How many threads a process has, whoever started them.

#include <filesystem>
#include <iterator>
#include <string>

namespace mapjoin::testing {

/// Of the process with that number; "self": of this one.
inline std::ptrdiff_t threads_of(const std::string& process) {
  return std::distance(std::filesystem::directory_iterator("/proc/" + process + "/task"), {});
}

}  // namespace mapjoin::testing
