// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The messages of errors, for tests to compare.

#include <mapjoin/model/error.hpp>
#include <string>

namespace mapjoin::testing {

/// The message of the error; empty if there is none.
template <typename T>
std::string error_of(const Expected<T>& result) {
  return result ? "" : result.error().message;
}

}  // namespace mapjoin::testing
