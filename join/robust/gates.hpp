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

}  // namespace mapjoin
