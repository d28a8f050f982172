// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/association/matching/sighting_chance.hpp>

namespace mapjoin {
namespace {

/// Number of rings of distances, with equally many trials in each.
constexpr std::size_t kRings = 20;

}  // namespace

SightingChance::SightingChance(std::vector<SightingTrial> trials) {
  std::ranges::sort(trials);
  std::size_t begin = 0;
  for (std::size_t ring = 0; ring < kRings; ++ring) {
    const std::size_t end = trials.size() * (ring + 1) / kRings;
    if (end == begin) continue;
    const auto seen = std::count_if(trials.begin() + static_cast<std::ptrdiff_t>(begin),
                                    trials.begin() + static_cast<std::ptrdiff_t>(end), [](const auto& t) { return t.second; });
    // Laplace's rule of succession: never quite certain.
    rings_.push_back({trials[end - 1].first, (static_cast<double>(seen) + 1.0) / (static_cast<double>(end - begin) + 2.0)});
    begin = end;
  }
}

double SightingChance::operator()(double distance) const {
  const auto ring = std::ranges::lower_bound(rings_, distance, {}, &Ring::end);
  return ring == rings_.end() ? 0.0 : ring->chance;
}

double SightingChance::log_overlooked(double distance, double error) const {
  const auto nearest = std::ranges::lower_bound(rings_, distance - error, {}, &Ring::end);
  const auto farthest = std::ranges::lower_bound(rings_, distance + error, {}, &Ring::end);
  if (farthest == rings_.end()) return 0.0;
  const auto least = std::ranges::min_element(nearest, farthest + 1, {}, &Ring::chance);
  return std::log1p(-least->chance);
}

}  // namespace mapjoin
