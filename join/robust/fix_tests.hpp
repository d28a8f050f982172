// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Tests of the fixes of a satellite receiver, each against all that is said without it.

#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/model/log.hpp>
#include <optional>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// The squared Mahalanobis distance of each pose prior of a log from its prediction by all else that counts, at the optimum
/// `log.initial` over the rest and the priors that count, which are those without Loss::dropped(). nullopt if what counts
/// leaves something free to move.
template <int Dim>
std::optional<std::vector<PartTest>> fix_tests(Log<Dim> log, Engine engine, const std::stop_token& stop);

}  // namespace mapjoin
