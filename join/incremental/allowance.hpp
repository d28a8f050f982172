// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far an estimate that puts work off may be above the optimum, and which part of that each kind of work has.

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace mapjoin {

/// Shares of chi2, of a thousandth in all. Each part is the chi2 that the work put off would take away at most; the sum holds
/// for what pulls different ways, as what was put off for different reasons does.
struct Allowance {
  double chi2 = 0.0;      ///< Of the optimum, or less.
  std::int64_t rows = 0;  ///< Measured.
  std::int64_t free = 0;  ///< Entries.

  /// What all maps together may err by as they are linearised: at least 0.3 % of a standard deviation in each row.
  double error() const { return std::max(1e-5 * static_cast<double>(rows), kLittle * chi2); }
  /// What a variable may stay away by from where the tree has it, in squared standard deviations per entry: at least 1e-6.
  double move() const { return std::max(1e-6, kLittle * chi2 / static_cast<double>(free)); }
  /// What variables of the tree might gain that stay where they are while maps are deferred.
  double gain() const { return 7e-4 * chi2; }
  /// What chi2 at the estimate may be off by from that of the linearised maps, both pulling the same way.
  double rounding() const { return std::pow(std::sqrt(error()) + std::sqrt(move() * static_cast<double>(free)), 2); }

 private:
  static constexpr double kLittle = 1e-4;
};

}  // namespace mapjoin
