// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// When a Cholesky pivot is nothing but what rounding left.

#include <cmath>

namespace mapjoin {

/// Whether the pivot L_jj has lost all its digits to cancellation, or never had any: L_jj² below 1e-14 of the diagonal entry
/// A_jj of the matrix, which is then singular to working precision.
inline bool has_lost_digits(double pivot, double diagonal) {
  return !(pivot * pivot > 1e-14 * std::abs(diagonal));
}

}  // namespace mapjoin
