// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How closely measurements that count as right fit.

#include <mapjoin/join/fit/leave_one_out.hpp>
#include <span>

namespace mapjoin {

/// No scale is less than this, however closely all fit: an error of zero would leave nothing to weigh others by.
inline constexpr double kLeastScale = 0.001;

/// By how much the leave-one-out tests of measurements that count as right are smaller than covariances say: the largest of the
/// ratios of several quantiles, so that the tail counts, too, with a margin for how few they are; at most 1, and 1 where they
/// are too few to tell. Only tests of `rows` rows are looked at.
double scale_of(std::span<const PartTest> tests, int rows);

}  // namespace mapjoin
