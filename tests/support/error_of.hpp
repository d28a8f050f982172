// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What went wrong, as a test compares it.

#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin::testing {

/// The sentence of the error; empty where there is none.
template <typename T>
std::string error_of(const Expected<T>& result) {
  return result ? "" : result.error().message;
}

}  // namespace mapjoin::testing
