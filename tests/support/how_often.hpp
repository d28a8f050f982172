// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How often a test that draws or repeats does so: few times every day, many where the environment asks for it.

#include <cstdlib>

namespace mapjoin::testing {

/// The number in the environment variable `name`, or `usually` where there is none.
inline int how_often(const char* name, int usually) {
  const char* asked = std::getenv(name);
  return asked ? std::atoi(asked) : usually;
}

}  // namespace mapjoin::testing
