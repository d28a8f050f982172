// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Repeated edges: several between the same two poses.

#include <algorithm>
#include <cstdint>
#include <mapjoin/model/factor.hpp>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// The number of edges beyond the first between the same two poses, whatever their direction.
template <int Dim>
std::int64_t count_repeated(std::span<const PoseFactor<Dim>> edges) {
  std::vector<std::pair<PoseIndex, PoseIndex>> ends;
  ends.reserve(edges.size());
  for (const auto& edge : edges) ends.emplace_back(std::minmax(edge.base, edge.target));
  std::sort(ends.begin(), ends.end());
  return ends.end() - std::unique(ends.begin(), ends.end());
}

}  // namespace mapjoin
