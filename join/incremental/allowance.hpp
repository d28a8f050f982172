// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The excess over the optimal chi2 that deferred work may leave, and the share of each kind of work.

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mapjoin {

/// The allowances for deferred work, shares of chi2, of a thousandth in all. Each bounds the chi2 that the deferred work would
/// take away; they add up if errors pull in different ways, as those of different reasons do.
struct Allowance {
  double chi2 = 0.0;      ///< chi2 of the optimum, or less.
  std::int64_t rows = 0;  ///< Measured rows.
  std::int64_t free = 0;  ///< Free entries of the state.

  /// The linearisation error allowed to all maps together: at least 0.3 % of a standard deviation in each row.
  double error() const { return std::max(1e-5 * static_cast<double>(rows), kLittle * chi2); }
  /// The distance allowed between a variable and its place in the tree, in squared standard deviations per entry: at least
  /// 1e-6.
  double move() const { return std::max(1e-6, kLittle * chi2 / static_cast<double>(free)); }
  /// The decrease of chi2 that variables of the tree may miss by staying where they are while maps are deferred.
  double gain() const { return 7e-4 * chi2; }
  /// The difference allowed between chi2 at the estimate and that of the linearised maps, error() and move() pulling the same
  /// way.
  double rounding() const { return std::pow(std::sqrt(error()) + std::sqrt(move() * static_cast<double>(free)), 2); }

 private:
  static constexpr double kLittle = 1e-4;
};

}  // namespace mapjoin
