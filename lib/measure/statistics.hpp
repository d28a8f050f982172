// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Order statistics, ratios that are whole but for rounding, and the chi-squared distribution.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <map>
#include <utility>
#include <vector>

namespace mapjoin {

/// The quantile of at least one value: a share p of them, 0 <= p < 1, precedes it in ascending order.
template <typename T>
T sample_quantile(std::vector<T> values, double p) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(p * static_cast<double>(values.size()));
  std::ranges::nth_element(values, nth);
  return *nth;
}

/// The median of at least one value; the upper one of the two in the middle if their number is even.
template <typename T>
T median(std::vector<T> values) {
  return sample_quantile(std::move(values), 0.5);
}

/// A value that counts as much as its weight.
struct Weighted {
  double value = 0.0;
  double weight = 0.0;
};

/// The least of the values by which half of the weight is reached; of at least one.
double weighted_median(std::vector<Weighted> values);

/// The whole part of a ratio of at least zero; one that is a whole number but for rounding, relative to it, is that number.
std::int64_t whole_part(double ratio);
/// True if a ratio is a whole number but for rounding, relative to it.
bool is_whole(double ratio);

/// The value that comes after `rank` others in descending order; of more than `rank` values.
template <typename T>
T nth_largest(std::vector<T> values, std::size_t rank) {
  const auto nth = values.begin() + static_cast<std::ptrdiff_t>(rank);
  std::ranges::nth_element(values, nth, std::greater<>());
  return *nth;
}

/// The probability that chi-squared exceeds `value` with `dof` degrees of freedom; 1 without any, NaN for NaN.
double chi_squared_upper_tail(double value, double dof);
/// The logarithm of chi_squared_upper_tail(), also if that is too small for a double.
double log_chi_squared_upper_tail(double value, double dof);

/// The chi-squared value that is exceeded with probability 1 - `p`, 0 < p < 1; 0 without degrees of freedom.
double chi_squared_quantile(double p, double dof);
/// The chi-squared value that is exceeded with probability `tail`, 0 < tail < 1, however small; 0 without degrees of freedom.
double chi_squared_upper_quantile(double tail, double dof);

/// The chi-squared values that are exceeded with one probability, computed once for each number of degrees of freedom.
class ChiSquaredQuantiles {
 public:
  explicit ChiSquaredQuantiles(double tail) : tail_(tail) {}
  double operator()(std::int64_t dof) {
    const auto [known, is_new] = of_.emplace(dof, 0.0);
    if (is_new) known->second = chi_squared_upper_quantile(tail_, static_cast<double>(dof));
    return known->second;
  }

 private:
  double tail_;
  std::map<std::int64_t, double> of_;
};

}  // namespace mapjoin
