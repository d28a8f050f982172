// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Methods that make a map of a log with wrong closures and observations.

#include <mapjoin/join/robust/inliers.hpp>
#include <string>
#include <vector>

#include "outlier_score.hpp"

namespace mapjoin::bench {

/// The start of Ceres.
enum class CeresStart : std::uint8_t { kOdometry, kCleanMap };
constexpr auto enum_names(CeresStart) {
  return std::to_array<EnumName<CeresStart>>({{CeresStart::kOdometry, "odometry"}, {CeresStart::kCleanMap, "clean"}});
}

struct MethodOptions {
  RobustOptions robust;
  CeresStart start = CeresStart::kOdometry;
  double most_seconds = 60.0;  ///< Time limit of Ceres for a map (s).
};

/// The names of the methods: "mapjoin" and the losses of Ceres.
std::vector<std::string> method_names();

/// Makes a map by one of method_names(). mapjoin rejects outliers and joins. Ceres solves with the loss, keeps the closures and
/// observations whose chi2 is within the quantile that the confidence, divided among all of them (Bonferroni), allows, and
/// solves these by least squares from there.
template <int Dim>
Expected<RobustMap<Dim>> map_robustly(const std::string& method, const Log<Dim>& log, const Values<Dim>& clean,
                                      const MethodOptions& options);

}  // namespace mapjoin::bench
