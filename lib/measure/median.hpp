// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The median.

#include <algorithm>
#include <cstddef>
#include <vector>

namespace mapjoin {

/// Of values that there are; of an even number the upper one of the two in the middle.
template <typename T>
T median(std::vector<T> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

}  // namespace mapjoin
