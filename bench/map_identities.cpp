// SPDX-License-Identifier: BSD-3-Clause
#include "map_identities.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstdio>
#include <mapjoin/join/run.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/simulate/wrong_measurements.hpp>

#include "outlier_score.hpp"

namespace mapjoin::bench {
namespace {

/// Counts the features that can be told right or wrong, and those of them that were rejected.
template <int Dim>
OutlierScore counted(const SubmapSet<Dim>& clean, const PlantedSet<Dim>& planted, const SubmapSet<Dim>& kept) {
  Table<FeatureIndex, int> right(clean.features.size());  // maps that have the feature rightly
  for (std::size_t m = 0; m < planted.is_wrong.size(); ++m) {
    for (std::size_t k = 0; k < planted.is_wrong[m].size(); ++k) {
      right[clean.graph.submaps[m].features[k]] += planted.is_wrong[m][k] ? 0 : 1;
    }
  }
  OutlierScore score;
  for (std::size_t m = 0; m < planted.is_wrong.size(); ++m) {
    const auto& names_kept = kept.graph.submaps[m].features;
    for (std::size_t k = 0; k < planted.is_wrong[m].size(); ++k) {
      const FeatureIndex given = planted.set.graph.submaps[m].features[k];
      const bool is_rejected = std::ranges::find(names_kept, given) == names_kept.end();
      const bool is_wrong = planted.is_wrong[m][k];
      const int others = is_wrong ? std::min(right[given], right[clean.graph.submaps[m].features[k]]) : right[given] - 1;
      if (others < 2) {
        ++score.undecided;
        score.undecided_rejected += is_rejected ? 1 : 0;
      } else {
        ++(is_wrong ? score.wrong : score.right);
        (is_wrong ? score.wrong_rejected : score.right_rejected) += is_rejected ? 1 : 0;
      }
    }
  }
  return score;
}

template <int Dim>
void compare(const RunResult<Dim>& clean, const RunResult<Dim>& robust, OutlierScore& score) {
  score.rms = rms_between<Dim>(clean.map.poses, robust.map.poses);
  score.features_off = count_features_off<Dim>(clean.map.features, clean.marginals->features, robust.map.features);
}

}  // namespace

template <int Dim>
Expected<void> print_map_identities(const std::string& name, const SubmapSet<Dim>& set, const MapIdentitiesOptions& options) {
  const auto clean_seconds = clean_cpu_seconds(set);
  if (!clean_seconds) return tl::unexpected(clean_seconds.error());
  RunOptions join = without_verdict();
  join.marginals = true;
  const auto clean = run(SubmapSet<Dim>(set), join);
  if (!clean) return tl::unexpected(clean.error());
  for (const double share : options.shares) {
    for (std::uint64_t seed = 1; seed <= options.seeds; ++seed) {
      const PlantedSet<Dim> planted = plant_wrong_identities(set, share, seed);
      const EffortMeter meter;
      const auto inliers = find_inliers(planted.set, options.robust);
      if (!inliers) return tl::unexpected(inliers.error());
      const auto robust = run(SubmapSet<Dim>(inliers->input), without_verdict());
      const double seconds = meter.so_far().cpu_seconds;
      if (!robust) return tl::unexpected(robust.error());
      OutlierScore s = counted(set, planted, inliers->input);
      compare(*clean, *robust, s);
      fmt::print("{},identities,{:.3f},{},mapjoin,{},{},{},{},{},{},{},{:.5f},{:.5f},{:.4g},,{},{:.2f},{:.2f}\n", name, share,
                 seed, s.right, s.wrong + s.undecided, s.wrong, s.wrong_rejected, s.wrong - s.wrong_rejected,
                 s.undecided - s.undecided_rejected, s.right_rejected, s.precision(), s.recall(), s.rms, s.features_off,
                 seconds, seconds / *clean_seconds);
      std::fflush(stdout);
    }
  }
  return {};
}

template Expected<void> print_map_identities(const std::string&, const SubmapSet<2>&, const MapIdentitiesOptions&);
template Expected<void> print_map_identities(const std::string&, const SubmapSet<3>&, const MapIdentitiesOptions&);

}  // namespace mapjoin::bench
