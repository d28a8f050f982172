// SPDX-License-Identifier: BSD-3-Clause
#include "robust_methods.hpp"

#include <algorithm>
#include <mapjoin/measure/effort.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/linearise.hpp>
#include <tests/support/starts.hpp>

#include "ceres_slam.hpp"

namespace mapjoin::bench {
namespace {

constexpr const char* kMapjoin = "mapjoin";

template <int Dim>
Expected<RobustMap<Dim>> by_mapjoin(const Log<Dim>& log, const RobustOptions& options) {
  const EffortMeter meter;
  auto inliers = find_inliers(log, options);
  if (!inliers) return tl::unexpected(inliers.error());
  return run(inliers->input, without_verdict()).map([&](RunResult<Dim>&& result) {
    return RobustMap<Dim>{
        std::move(inliers->input), {std::move(result.map.poses), std::move(result.map.features)}, meter.so_far().cpu_seconds};
  });
}

/// The log without closures and observations whose residual is larger than the confidence allows.
template <int Dim>
Log<Dim> without_misfits(const Log<Dim>& log, const Values<Dim>& values, double confidence) {
  const auto doubtful = static_cast<double>(log.closures().size() + log.observations().size());
  const double p = 1.0 - (1.0 - confidence) / std::max(1.0, doubtful);
  const auto is_misfit = [&](const auto& factor, const auto& target, int rows) {
    const auto r = residual<Dim>(factor.measured, values.poses[factor.base], target);
    return r.dot(factor.information * r) > chi_squared_quantile(p, rows);
  };
  Log<Dim> kept = log;
  auto& factors = kept.graph.pose_factors;
  factors.assign(log.odometry().begin(), log.odometry().end());
  std::ranges::copy_if(log.closures(), std::back_inserter(factors),
                       [&](const auto& o) { return !is_misfit(o, values.poses[o.target], kPoseDof<Dim>); });
  factors.insert(factors.end(), log.pose_priors().begin(), log.pose_priors().end());
  std::erase_if(kept.graph.feature_factors,
                [&](const auto& o) { return o.base != kWorld && is_misfit(o, values.features[o.target], Dim); });
  return kept;
}

template <int Dim>
RobustMap<Dim> by_ceres(CeresLoss loss, const Log<Dim>& log, const Values<Dim>& clean, const MethodOptions& options) {
  const EffortMeter meter;
  const Values<Dim> start = options.start == CeresStart::kCleanMap ? clean : testing::odometry_start(log);
  CeresOptions ceres{.loss = loss, .most_seconds = options.most_seconds};
  const Values<Dim> robust = solve_by_ceres(log, start, ceres).values;
  Log<Dim> kept = without_misfits(log, robust, options.robust.confidence);
  ceres.loss = CeresLoss::kPlain;
  ceres.most_seconds = std::max(1.0, options.most_seconds - meter.so_far().seconds);
  Values<Dim> values = solve_by_ceres(kept, robust, ceres).values;
  return {std::move(kept), std::move(values), meter.so_far().cpu_seconds};
}

}  // namespace

std::vector<std::string> method_names() {
  std::vector<std::string> names = {kMapjoin};
  for (const auto& [loss, name] : enum_names(CeresLoss{})) names.emplace_back(name);
  return names;
}

template <int Dim>
Expected<RobustMap<Dim>> map_robustly(const std::string& method, const Log<Dim>& log, const Values<Dim>& clean,
                                      const MethodOptions& options) {
  for (const auto& [loss, name] : enum_names(CeresLoss{})) {
    if (method == name) return by_ceres(loss, log, clean, options);
  }
  return by_mapjoin(log, options.robust);
}

template Expected<RobustMap<2>> map_robustly(const std::string&, const Log<2>&, const Values<2>&, const MethodOptions&);
template Expected<RobustMap<3>> map_robustly(const std::string&, const Log<3>&, const Values<3>&, const MethodOptions&);

}  // namespace mapjoin::bench
