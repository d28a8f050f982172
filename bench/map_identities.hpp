// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Wrong identities planted into sets of local maps: which of them does robust joining name?

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

/// Prints a line of CSV for each share and seed, of the columns of mapjoin_outliers. Right and wrong are counted of features
/// whose names two other maps give rightly; of wrong ones, whose true names as well. Errors are those of the robust join.
template <int Dim>
Expected<void> print_map_identities(const std::string& name, const SubmapSet<Dim>& set, const MapIdentitiesOptions& options);

}  // namespace mapjoin::bench
