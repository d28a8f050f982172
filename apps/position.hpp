// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The position of a pose or a feature, known or not.

namespace mapjoin::apps {

/// The position of a pose or a feature; null if unknown.
template <typename T>
auto position_of(const T& one) {
  if constexpr (requires { one.has_value(); }) {
    return one ? position_of(*one) : nullptr;
  } else if constexpr (requires { one.translation; }) {
    return &one.translation;
  } else {
    return &one;
  }
}

}  // namespace mapjoin::apps
