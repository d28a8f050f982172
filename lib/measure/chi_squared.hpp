// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// What a sum of squares of that many standard normal variables may be.

namespace mapjoin {

/// The probability of a value larger than `value` with `dof` degrees of freedom; 1 without any.
double chi_squared_upper_tail(double value, double dof);

/// The value that is exceeded with the probability 1 - `p`, 0 < p < 1; 0 without degrees of freedom.
double chi_squared_quantile(double p, double dof);

}  // namespace mapjoin
