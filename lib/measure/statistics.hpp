// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Values by their rank, and what a sum of squares of so many standard normal variables may be.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace mapjoin {

/// The value that a share p of them, 0 <= p < 1, precedes in ascending order; of at least one value.
template <typename T>
T sample_quantile(std::vector<T> values, double p) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size()));
  std::ranges::nth_element(values, nth);
  return *nth;
}

/// The median of at least one value; of an even number the upper one of the two in the middle.
template <typename T>
T median(std::vector<T> values) {
  return sample_quantile(std::move(values), 0.5);
}

/// The value that `rank` others precede in descending order; of more than `rank` values.
template <typename T>
T nth_largest(std::vector<T> values, std::size_t rank) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::ranges::nth_element(values, nth, std::greater<>());
  return *nth;
}

/// The probability of a value larger than `value` with `dof` degrees of freedom; 1 without any.
double chi_squared_upper_tail(double value, double dof);
/// Its logarithm, also where it is too small for a double.
double log_chi_squared_upper_tail(double value, double dof);

/// The value that is exceeded with the probability 1 - `p`, 0 < p < 1; 0 without degrees of freedom.
double chi_squared_quantile(double p, double dof);
/// The value that is exceeded with the probability `tail`, 0 < tail < 1, however small; 0 without degrees of freedom.
double chi_squared_upper_quantile(double tail, double dof);

/// The quantiles of one probability, each computed once.
class ChiSquaredQuantiles {
 public:
  explicit ChiSquaredQuantiles(double p) : p_(p) {}
  double operator()(std::int64_t dof) {
    const auto [known, is_new] = of_.emplace(dof, 0.0);
    if (is_new) known->second = chi_squared_quantile(p_, static_cast<double>(dof));
    return known->second;
  }

 private:
  double p_;
  std::map<std::int64_t, double> of_;
};

}  // namespace mapjoin
