// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <apps/picture/links.hpp>
#include <cmath>
#include <mapjoin/check/fit.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin::apps {
namespace {

constexpr std::size_t kUnknown = 1;
constexpr std::size_t kTypical = 2;

constexpr std::size_t kFew = 20;
constexpr double kLeastScale = 1e-12;  // a millionth of a standard deviation: below, residuals are round-off

/// Adds the links of one kind.
template <int Dim, typename Factor, typename Targets>
void add_links(std::span<const Factor> factors, const Targets& targets, const GlobalMap<Dim>& map, std::vector<Link>& links) {
  std::vector<WeighedResidual> weighed;
  const std::size_t first = links.size();
  for (const Factor& o : factors) {
    if (o.base == kWorld) continue;
    const auto r = residual<Dim>(o.measured, map.poses[o.base], targets[o.target]);
    const auto rows = information_rank<r.RowsAtCompileTime>(o.information);
    const double chi2 = std::max(0.0, r.dot(o.information * r));
    links.push_back({o.base, o.target, false, std::sqrt(chi2 / static_cast<double>(std::max<std::int64_t>(rows, 1)))});
    weighed.push_back({chi2, rows});
  }
  const double scale = weighed.size() < kFew ? 1.0 : std::max(kLeastScale, median_scale(weighed));
  for (std::size_t k = first; k < links.size(); ++k) *links[k].residual /= std::sqrt(scale);
}

}  // namespace

std::size_t class_of(const Link& link) {
  if (link.is_rejected) return 0;
  if (!link.residual) return kUnknown;
  const double doublings = std::ceil(std::log2(*link.residual)) - 1.0;
  return kTypical + static_cast<std::size_t>(std::clamp(doublings, 0.0, kLinkClasses.size() - 1.0 - kTypical));
}

template <int Dim>
std::vector<Link> links_of(std::span<const PoseFactor<Dim>> closures, std::span<const FeatureFactor<Dim>> observations,
                           const GlobalMap<Dim>& map) {
  std::vector<Link> links;
  add_links(closures, map.poses, map, links);
  add_links(observations, map.features, map, links);
  return links;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template std::vector<Link> links_of(std::span<const PoseFactor<Dim>>, std::span<const FeatureFactor<Dim>>, \
                                      const GlobalMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::apps
