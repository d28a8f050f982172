// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/association/tracking/log_tracking.hpp>
#include <mapjoin/join/association/tracking/sighting_density.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <optional>
#include <utility>

namespace mapjoin {
namespace {

/// In the first pass features are broken up; in the second hardly any are, so that the third one knows how surely they are
/// seen.
constexpr int kPasses = 3;

/// The tracked observations of all segments, with features numbered consecutively.
template <int Dim>
std::vector<Tracked> numbered(const std::vector<Tracks<Dim>>& of_segments) {
  std::vector<Tracked> all;
  std::size_t first = 0;
  for (const auto& tracks : of_segments) {
    std::size_t next = first;
    for (const auto& [feature, match] : tracks.observations) {
      all.push_back({first + feature, match});
      next = std::max(next, first + feature + 1);
    }
    first = next;
  }
  return all;
}

/// The chance of a sighting by the trials of all segments, which are given up: there are very many.
template <int Dim>
SightingChance chance_of(std::vector<Tracks<Dim>>& of_segments) {
  std::vector<SightingTrial> trials;
  for (auto& tracks : of_segments) {
    const std::vector<SightingTrial> some = std::exchange(tracks.trials, {});
    trials.insert(trials.end(), some.begin(), some.end());
  }
  return SightingChance(std::move(trials));
}

/// The density of the features that were followed; nullopt if these are too few.
template <int Dim>
std::optional<double> density_followed(const std::vector<Tracks<Dim>>& of_segments, const PointMatrix<Dim>& noise) {
  std::vector<std::vector<Point<Dim>>> followed;
  for (const auto& tracks : of_segments) followed.push_back(tracks.followed);
  return mean_density<Dim>(followed, noise);
}

}  // namespace

template <int Dim>
std::vector<Tracked> track_log(const Log<Dim>& log, const Split& split, const AssociationOptions& options,
                               NeighbourDensity<Dim>& density, const std::stop_token& stop) {
  const int passes = options.method == AssociationMethod::kNearest ? 1 : kPasses;  // which looks at distances alone
  const PointMatrix<Dim> noise = mean_noise<Dim>(log.observations(), {});
  const double seen_at_once = density.overall();
  SightingChance sees;
  std::vector<Tracks<Dim>> of_segments(split.segments.size());
  for (int pass = 0; pass < passes && !stop.stop_requested(); ++pass) {
    if (pass > 0) sees = chance_of(of_segments);
    parallel_for(of_segments.size(), [&](std::size_t k) {
      if (stop.stop_requested()) return;
      Matcher<Dim> matcher(density, options.method, options.confidence, static_cast<double>(log.observations().size()));
      of_segments[k] = track(segment_view(log, split, split.segments[k]), sees, matcher, options.confidence);
    });
    density.set_overall(std::max(seen_at_once, density_followed(of_segments, noise).value_or(0.0)));
  }
  return numbered(of_segments);
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                            \
  template std::vector<Tracked> track_log(const Log<Dim>&, const Split&, const AssociationOptions&, NeighbourDensity<Dim>&, \
                                          const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
