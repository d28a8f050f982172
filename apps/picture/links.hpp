// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Closures and observations as lines of a picture, in classes by their residuals, and what `--robust` left out of a map.

#include <array>
#include <cstddef>
#include <filesystem>
#include <mapjoin/model/factor.hpp>
#include <mapjoin/model/global_map.hpp>
#include <mapjoin/model/ids.hpp>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin::apps {

struct RunReport;

/// A closure or an observation in a map.
struct Link {
  PoseIndex from;
  PoseOrFeature to;
  bool is_rejected = false;  ///< Left out of the map.
  /// Its weighted residual √(rᵀWr / rank W) over the typical one of its kind or, where there are few of that, over what the
  /// covariances say; none where the map is no estimate or the link is rejected.
  std::optional<double> residual = {};
};

/// The style of a class of links; a colour each for a light and a dark background.
struct LinkClass {
  const char* name;  ///< In a legend.
  const char* on_light;
  const char* on_dark;
  double width;  ///< In pixels.
  bool is_dashed = false;
  bool is_on_top = false;  ///< Over all else that is drawn, for it needs to be seen.
};

/// In the order in which they are drawn, the worst last. Its colours leave the background step by step, so that they are in
/// order without their hues, too.
inline constexpr std::array<LinkClass, 6> kLinkClasses = {{
    {"rejected", "#7b52c9", "#b79cf0", 0.7, true},
    {"loop closures", "#8a94a6", "#6b7280", 0.5},
    {"residual ≤ 2 × typical", "#c6cbd3", "#434a56", 0.5},
    {"residual 2–4 × typical", "#e08a4f", "#b05a44", 0.9},
    {"residual 4–8 × typical", "#b3263a", "#f09c50", 1.5, false, true},
    {"residual > 8 × typical", "#45041a", "#fff3c4", 2.2, false, true},
}};

/// The place of its class in kLinkClasses.
std::size_t class_of(const Link& link);

/// Those of the closures, then of the observations; priors, whose base is the World, are none.
template <int Dim>
std::vector<Link> links_of(std::span<const PoseFactor<Dim>> closures, std::span<const FeatureFactor<Dim>> observations,
                           const GlobalMap<Dim>& map);

/// Those that a run left out.
void add_rejected_links(const RunReport& run_report, std::vector<Link>& links);

/// Those of the `rejected.csv` in the folder of a run, under the names of its `poses.csv` and `features.csv`, for its map as it
/// was read from there; none where there is no such file. Fails with bad input where the files are not of one map.
template <int Dim>
void add_rejected_links(const std::filesystem::path& folder, const GlobalMap<Dim>& map, std::vector<Link>& links);

}  // namespace mapjoin::apps
