// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Numbers of things in sentences.

#include <concepts>
#include <string>

namespace mapjoin {

/// "1 edge", "2 edges"; "2 matrices" where `things` are not `thing` and an s.
template <std::integral Count>
std::string plural(Count count, const std::string& thing, const std::string& things = "") {
  return std::to_string(count) + " " + (count == 1 ? thing : things.empty() ? thing + "s" : things);
}

}  // namespace mapjoin
