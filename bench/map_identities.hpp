// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Robust joining against wrong identities planted into sets of local maps.

#include <cstdint>
#include <mapjoin/join/robust/inliers.hpp>
#include <string>
#include <vector>

namespace mapjoin::bench {

struct MapIdentitiesOptions {
  std::vector<double> shares;
  std::uint64_t seeds = 1;
  RobustOptions robust;
};

/// Prints a line of CSV for each share and seed, with the columns of mapjoin_outliers. A feature of a map counts as right or
/// wrong if two other maps have its name rightly and, if it is wrong, two have its true name; otherwise as undecided. Errors
/// are those of run() and find_inliers().
template <int Dim>
Expected<void> print_map_identities(const std::string& name, const SubmapSet<Dim>& set, const MapIdentitiesOptions& options);

}  // namespace mapjoin::bench
