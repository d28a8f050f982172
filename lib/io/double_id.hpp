// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Ids that a file holds as doubles.

#include <cmath>
#include <cstdint>
#include <optional>

namespace mapjoin {

/// Ids end before it: every integer below is a double, and no other integer rounds to it.
inline constexpr double kDoubleIdEnd = 9007199254740992.0;  // 2⁵³

/// The id that `value` is, or nothing.
inline std::optional<std::uint64_t> id_of(double value) {
  if (!(value >= 0.0 && value < kDoubleIdEnd) || value != std::floor(value)) return std::nullopt;
  return static_cast<std::uint64_t>(value);
}

}  // namespace mapjoin
