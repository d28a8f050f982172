// SPDX-License-Identifier: BSD-3-Clause
#include "outlier_score.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>
#include <cmath>
#include <mapjoin/measure/chi2.hpp>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/model/linearise.hpp>
#include <span>

namespace mapjoin::bench {
namespace {

constexpr double kWrongFrom = 10.0 * 10.0;  // squared Mahalanobis distance
constexpr double kOffFrom = 3.0 * 3.0;      // squared Mahalanobis distance of a feature from its place in the clean map

template <int Dim>
Pose<Dim> seen_from(const Pose<Dim>& base, const Pose<Dim>& target) {
  return between(base, target);
}
template <int Dim>
Point<Dim> seen_from(const Pose<Dim>& base, const Point<Dim>& target) {
  return transform_into(base, target);
}

/// rᵀ (C + W⁻¹)⁻¹ r; W may be singular.
template <int Dof>
double squared_distance(const Vector<Dof>& r, const Matrix<Dof>& C, const Matrix<Dof>& W) {
  const Matrix<Dof> scaled = Matrix<Dof>::Identity() + W * C;
  const Vector<Dof> weighted = W * r;
  return r.dot(Vector<Dof>(scaled.partialPivLu().solve(weighted)));
}

/// The targets in the clean map: values and covariances.
template <int Dim>
struct TargetOf {
  const CleanMap<Dim>& clean;
  const Pose<Dim>& value(PoseIndex pose) const { return clean.values.poses[pose]; }
  const Point<Dim>& value(FeatureIndex feature) const { return clean.values.features[feature]; }
  const PoseMatrix<Dim>& covariance(PoseIndex pose) const { return clean.marginals.poses[pose]; }
  const PointMatrix<Dim>& covariance(FeatureIndex feature) const { return clean.marginals.features[feature]; }
  PoseMatrix<Dim> relative(PoseIndex base, PoseIndex pose) const {
    return clean.covariances->relative_pose(base, pose).value();
  }
  PointMatrix<Dim> relative(PoseIndex base, FeatureIndex feature) const {
    return clean.covariances->relative_feature(base, feature).value();
  }
};

/// True if a measurement is far from its prediction by the clean map. Without the covariance of the prediction the distance is
/// larger; with twice the sum of the contributions of both ends, which the covariance never exceeds however they are
/// correlated, it is smaller. Few measurements need the exact one.
template <int Dim, typename Factor>
bool is_far(const CleanMap<Dim>& clean, const Factor& factor) {
  const TargetOf<Dim> targets{clean};
  const Pose<Dim>& base = clean.values.poses[factor.base];
  const auto& target = targets.value(factor.target);
  const auto r = residual<Dim>(factor.measured, base, target);
  if (r.dot(factor.information * r) <= kWrongFrom) return false;
  const auto [none, J_target, J_base] = linearise<Dim>(seen_from<Dim>(base, target), base, target);
  using Covariance = std::decay_t<decltype(factor.information)>;
  const Covariance most = 2.0 * (J_base * clean.marginals.poses[factor.base] * J_base.transpose() +
                                 J_target * targets.covariance(factor.target) * J_target.transpose());
  if (squared_distance(r, most, factor.information) > kWrongFrom) return true;
  return squared_distance(r, targets.relative(factor.base, factor.target), factor.information) > kWrongFrom;
}

/// Appends true for each of `all` that is among `some`, otherwise false; both are in the same order.
template <typename Factor>
void add_membership(std::span<const Factor> all, std::span<const Factor> some, std::vector<bool>& is_in) {
  auto next = some.begin();
  for (const Factor& factor : all) {
    const bool is_next =
        next != some.end() && next->base == factor.base && next->target == factor.target && next->measured == factor.measured;
    is_in.push_back(is_next);
    if (is_next) ++next;
  }
}

}  // namespace

template <typename Data>
Expected<double> clean_cpu_seconds(const Data& data) {
  std::array<double, 3> seconds{};
  for (double& time : seconds) {
    const EffortMeter meter;
    if (const auto result = run(data, without_verdict()); !result) return tl::unexpected(result.error());
    time = meter.so_far().cpu_seconds;
  }
  std::ranges::sort(seconds);
  return seconds[1];
}

template <int Dim>
double rms_between(const Table<PoseIndex, Pose<Dim>>& a, const Table<PoseIndex, Pose<Dim>>& b) {
  double sum = 0.0;
  for (const PoseIndex p : indices(a)) sum += (a[p].translation - b[p].translation).squaredNorm();
  return std::sqrt(sum / static_cast<double>(a.size()));
}

template <int Dim>
std::size_t count_features_off(const Table<FeatureIndex, Point<Dim>>& clean,
                               const Table<FeatureIndex, PointMatrix<Dim>>& covariances,
                               const Table<FeatureIndex, Point<Dim>>& features) {
  std::size_t off = 0;
  for (const FeatureIndex f : indices(clean)) {
    const Point<Dim> d = features[f] - clean[f];
    off += d.dot(covariances[f].ldlt().solve(d)) > kOffFrom ? 1 : 0;
  }
  return off;
}

template <int Dim>
Expected<CleanMap<Dim>> make_clean_map(const Log<Dim>& log) {
  const auto cpu_seconds = clean_cpu_seconds(log);
  if (!cpu_seconds) return tl::unexpected(cpu_seconds.error());
  RunOptions options = without_verdict();
  options.covariances = true;
  options.marginals = true;
  return run(log, options).map([&](RunResult<Dim>&& result) {
    return CleanMap<Dim>{.log = log,
                         .values = {std::move(result.map.poses), std::move(result.map.features)},
                         .chi2 = result.chi2,
                         .cpu_seconds = *cpu_seconds,
                         .marginals = std::move(*result.marginals),
                         .covariances = std::move(result.covariances)};
  });
}

template <int Dim>
Spoilt<Dim> with_wrong_closures(const CleanMap<Dim>& clean, ClosurePolicy policy, std::size_t count, std::uint64_t seed) {
  Planted<Dim> planted = plant_wrong_closures(clean.log, policy, count, seed);
  const auto closures = planted.log.closures();
  std::vector<Truth> truth(closures.size() + planted.log.observations().size(), Truth::kRight);
  for (std::size_t k = 0; k < closures.size(); ++k) {
    if (planted.is_wrong[k]) truth[k] = is_far(clean, closures[k]) ? Truth::kWrong : Truth::kUndecided;
  }
  return {std::move(planted.log), std::move(truth)};
}

template <int Dim>
Spoilt<Dim> with_wrong_identities(const CleanMap<Dim>& clean, double share, std::uint64_t seed) {
  Planted<Dim> planted = plant_wrong_identities(clean.log, share, seed);
  const auto observations = planted.log.observations();
  Table<FeatureIndex, int> sightings(clean.log.features.size());
  for (std::size_t k = 0; k < observations.size(); ++k) sightings[observations[k].target] += planted.is_wrong[k] ? 0 : 1;
  const std::size_t closures = clean.log.closures().size();
  std::vector<Truth> truth(closures + observations.size(), Truth::kRight);
  for (std::size_t k = 0; k < observations.size(); ++k) {
    if (!planted.is_wrong[k]) continue;
    const bool are_seen = std::min(sightings[clean.log.observations()[k].target], sightings[observations[k].target]) >= 2;
    truth[closures + k] = are_seen && is_far(clean, observations[k]) ? Truth::kWrong : Truth::kUndecided;
  }
  return {std::move(planted.log), std::move(truth)};
}

double OutlierScore::precision() const {
  const std::size_t rejected = wrong_rejected + right_rejected;
  return rejected == 0 ? 1.0 : static_cast<double>(wrong_rejected) / static_cast<double>(rejected);
}

double OutlierScore::recall() const {
  return wrong == 0 ? 1.0 : static_cast<double>(wrong_rejected) / static_cast<double>(wrong);
}

template <int Dim>
OutlierScore score(const CleanMap<Dim>& clean, const Spoilt<Dim>& spoilt, const RobustMap<Dim>& robust) {
  std::vector<bool> is_kept;
  add_membership(spoilt.log.closures(), robust.kept.closures(), is_kept);
  add_membership(spoilt.log.observations(), robust.kept.observations(), is_kept);
  OutlierScore score;
  for (std::size_t k = 0; k < is_kept.size(); ++k) {
    const auto count = [&](std::size_t& all, std::size_t& rejected) {
      ++all;
      if (!is_kept[k]) ++rejected;
    };
    switch (spoilt.truth[k]) {
      case Truth::kRight:
        count(score.right, score.right_rejected);
        break;
      case Truth::kWrong:
        count(score.wrong, score.wrong_rejected);
        break;
      case Truth::kUndecided:
        count(score.undecided, score.undecided_rejected);
        break;
    }
  }
  score.rms = rms_between<Dim>(clean.values.poses, robust.values.poses);
  score.chi2_ratio = log_chi2(clean.log, robust.values).total() / clean.chi2;
  score.features_off = count_features_off<Dim>(clean.values.features, clean.marginals.features, robust.values.features);
  return score;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                             \
  template Expected<double> clean_cpu_seconds(const Log<Dim>&);                                              \
  template Expected<double> clean_cpu_seconds(const SubmapSet<Dim>&);                                        \
  template double rms_between<Dim>(const Table<PoseIndex, Pose<Dim>>&, const Table<PoseIndex, Pose<Dim>>&);  \
  template std::size_t count_features_off<Dim>(const Table<FeatureIndex, Point<Dim>>&,                       \
                                               const Table<FeatureIndex, PointMatrix<Dim>>&,                 \
                                               const Table<FeatureIndex, Point<Dim>>&);                      \
  template Expected<CleanMap<Dim>> make_clean_map(const Log<Dim>&);                                          \
  template Spoilt<Dim> with_wrong_closures(const CleanMap<Dim>&, ClosurePolicy, std::size_t, std::uint64_t); \
  template Spoilt<Dim> with_wrong_identities(const CleanMap<Dim>&, double, std::uint64_t);                   \
  template OutlierScore score(const CleanMap<Dim>&, const Spoilt<Dim>&, const RobustMap<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::bench
