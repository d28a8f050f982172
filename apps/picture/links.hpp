// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Closures and observations as lines of a picture, in classes by their residuals, and those that `--robust` rejected.

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
  bool is_rejected = false;  ///< True if it is left out of the map.
  /// Weighted residual √(rᵀWr / rank W) over the typical one of its kind or, if that has few links, over the one that the
  /// covariances imply; nullopt if the map is no estimate or the link is rejected.
  std::optional<double> residual = {};
};

/// The style of a class of links; a colour each for a light and a dark background.
struct LinkClass {
  const char* name;  ///< Name in a legend.
  const char* on_light;
  const char* on_dark;
  double width;  ///< Width of the line (pixels).
  bool is_dashed = false;
  bool is_on_top = false;  ///< True if drawn over everything else, to be seen.
};

/// The classes in drawing order, the worst last. Their colours leave the background step by step, so that they are in order
/// without their hues, too.
inline constexpr std::array<LinkClass, 6> kLinkClasses = {{
    {"rejected", "#7b52c9", "#b79cf0", 0.7, true},
    {"loop closures", "#8a94a6", "#6b7280", 0.5},
    {"residual ≤ 2 × typical", "#c6cbd3", "#434a56", 0.5},
    {"residual 2–4 × typical", "#e08a4f", "#b05a44", 0.9},
    {"residual 4–8 × typical", "#b3263a", "#f09c50", 1.5, false, true},
    {"residual > 8 × typical", "#45041a", "#fff3c4", 2.2, false, true},
}};

/// The index in kLinkClasses of the class of a link.
std::size_t class_of(const Link& link);

/// The links of the closures, then of the observations; priors, whose base is the World, are none.
template <int Dim>
std::vector<Link> links_of(std::span<const PoseFactor<Dim>> closures, std::span<const FeatureFactor<Dim>> observations,
                           const GlobalMap<Dim>& map);

/// Adds the links that a run rejected.
void add_rejected_links(const RunReport& run_report, std::vector<Link>& links);

/// Adds the links in the `rejected.csv` of a run between these poses and features; bad input if the file is of another map.
void add_rejected_links(const std::filesystem::path& file, const PoseIds& poses, const FeatureIds& features,
                        std::vector<Link>& links);

}  // namespace mapjoin::apps
