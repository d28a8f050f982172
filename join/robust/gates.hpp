// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far from its prediction a measurement may be and still count as right.

#include <mapjoin/join/fit/leave_one_out.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// By how much the leave-one-out tests of measurements that count as right are smaller than covariances say: the largest of the
/// ratios of several quantiles, so that the tail counts, too, with a margin for how few they are; at most 1, and 1 where they
/// are too few to tell. Only tests of `rows` rows are looked at.
double scale_of(std::span<const PartTest> tests, int rows);

/// A gate between `narrow`, how closely what is right fits, and `wide`, all that its covariances allow, for the squared
/// distances, of `dof` degrees of freedom, of measurements from their predictions by the others: the widest one beyond which so
/// few lie that hardly any wrong one can be among those between `narrow` and it, whether these count now or not. How many wrong
/// ones lie within a gate is read off the numbers up to twice and up to four times its width.
double gate_among(std::vector<double> distances, double narrow, double wide, int dof);

}  // namespace mapjoin
