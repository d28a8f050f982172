// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/robust/support/agreement.hpp>
#include <mapjoin/join/robust/support/sighting_support.hpp>
#include <mapjoin/parallel/parallel.hpp>

namespace mapjoin {
namespace {

/// An observation is compared with at most kMostCompared next ones of its feature, at most kFarthest steps away.
constexpr std::int32_t kFarthest = 60;
constexpr std::size_t kMostCompared = 20;
/// Poses of a group, whose observations may be wrong together.
constexpr std::int32_t kPosesOfAGroup = 25;

template <int Dim>
double evidence_of(const OdometryChain<Dim>& chain, const FeatureFactor<Dim>& a, const FeatureFactor<Dim>& b, double volume) {
  const UncertainPose<Dim> between = chain.relative(a.base, b.base);
  const Point<Dim> by_b = transform(between.mean, b.measured);
  PointPoseMatrix<Dim> J = PointPoseMatrix<Dim>::Zero();  // Jacobian of a position with respect to a twist of its frame
  J.template leftCols<Dim>().setIdentity();
  J.template rightCols<kRotationDof<Dim>>() = J_turned_rotation(by_b);
  const PointMatrix<Dim> R = between.mean.rotation.matrix();
  const PointMatrix<Dim> S =
      covariance_of(a.information) + R * covariance_of(b.information) * R.transpose() + J * between.covariance * J.transpose();
  return evidence<Dim>(a.measured - by_b, S, volume).at(1.0, kMostOfAPair);
}

template <int Dim>
double volume_of(std::span<const FeatureFactor<Dim>> observations) {
  Eigen::AlignedBox<double, Dim> box;
  for (const auto& o : observations) box.extend(o.measured);
  return box.sizes().cwiseMax(1.0).prod();
}

}  // namespace

template <int Dim>
std::vector<double> sighting_odds(const OdometryChain<Dim>& chain, const Log<Dim>& log) {
  const auto observations = log.observations();
  if (observations.empty()) return {};
  Table<FeatureIndex, std::vector<std::uint32_t>> of_feature(log.features.size());  // in the order of their poses
  for (std::size_t k = 0; k < observations.size(); ++k)
    of_feature[observations[k].target].push_back(static_cast<std::uint32_t>(k));
  const double volume = volume_of(observations);
  const auto group = [&](std::uint32_t k) { return static_cast<std::uint32_t>(observations[k].base.value / kPosesOfAGroup); };
  Agreements agreements(observations.size());
  parallel_for(of_feature.size(), [&](std::size_t f) {
    const auto& sightings = of_feature[FeatureIndex(f)];
    for (std::size_t a = 0; a < sightings.size(); ++a) {
      for (std::size_t b = a + 1; b < std::min(sightings.size(), a + 1 + kMostCompared); ++b) {
        const auto& first = observations[sightings[a]];
        const auto& second = observations[sightings[b]];
        if (second.base - first.base > kFarthest || !chain.is_tied(first.base, second.base)) break;
        const auto evidence = static_cast<float>(evidence_of(chain, first, second, volume));
        agreements[sightings[a]].push_back({sightings[b], group(sightings[b]), evidence});
        agreements[sightings[b]].push_back({sightings[a], group(sightings[a]), evidence});
      }
    }
    for (const std::uint32_t k : sightings) std::ranges::stable_sort(agreements[k], {}, &Agreement::group);
  });
  return odds_by_agreement(std::vector<PriorOdds>(observations.size()), agreements);
}

template std::vector<double> sighting_odds(const OdometryChain<2>&, const Log<2>&);
template std::vector<double> sighting_odds(const OdometryChain<3>&, const Log<3>&);

}  // namespace mapjoin
