// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A comparison as one page, with tables and pictures of the maps.

#include <apps/report/compare_report.hpp>
#include <apps/report/run_report.hpp>
#include <mapjoin/join/study/comparison.hpp>
#include <string>
#include <vector>

namespace mapjoin::apps {

/// `other_map` is the optimum with the other weights; without poses where there is none.
template <int Dim>
std::string compare_page(const Account& account, const Comparison<Dim>& comparison, const OtherWeights& other,
                         const GlobalMap<Dim>& other_map, const std::vector<Session>& sessions);

}  // namespace mapjoin::apps
