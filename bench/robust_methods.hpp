// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Ways of making a map of a log in which some closures and observations are wrong.

#include <mapjoin/join/robust/inliers.hpp>
#include <string>
#include <vector>

#include "outlier_score.hpp"

namespace mapjoin::bench {

/// Where Ceres begins.
enum class CeresStart : std::uint8_t { kOdometry, kCleanMap };
constexpr auto enum_names(CeresStart) {
  return std::to_array<EnumName<CeresStart>>({{CeresStart::kOdometry, "odometry"}, {CeresStart::kCleanMap, "clean"}});
}

struct MethodOptions {
  RobustOptions robust;
  CeresStart start = CeresStart::kOdometry;
  double most_seconds = 60.0;  ///< Of Ceres.
};

/// "mapjoin" and the losses of Ceres.
std::vector<std::string> method_names();

/// mapjoin rejects and joins. Ceres solves with the loss, which decides what is kept: residuals that a chi-squared distribution
/// exceeds with the probability that the confidence leaves to each of them; then it solves these by least squares from there.
/// The method is one of method_names().
template <int Dim>
Expected<RobustMap<Dim>> map_robustly(const std::string& method, const Log<Dim>& log, const Values<Dim>& clean,
                                      const MethodOptions& options);

}  // namespace mapjoin::bench
