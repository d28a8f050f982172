// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/check/fit.hpp>
#include <mapjoin/check/ties.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The ratios of residuals to what covariances say, above and below 1, that are worth a warning; the first makes a map look
/// better than it is.
constexpr double kLarger = 1.5;
constexpr double kSmaller = 2.0;
/// Fewer rows do not tell what is typical: a single residual would be typical of itself.
constexpr std::int64_t kLeastRows = 20;

template <int Dim>
WeighedResidual weighed(const PoseFactor<Dim>& o, const Values<Dim>& state) {
  return {cost(o, state.pose(o.base), state.pose(o.target)), information_rank<kPoseDof<Dim>>(o.information)};
}
template <int Dim>
WeighedResidual weighed(const FeatureFactor<Dim>& o, const Values<Dim>& state) {
  return {cost(o, state.pose(o.base), state.features[o.target]), information_rank<Dim>(o.information)};
}

template <int Dim>
std::string name_of(const PoseFactor<Dim>& o, const Log<Dim>& log) {
  const TieVertices of = vertices_of(log);
  return fmt::format("{} to {}", name_of(of.pose(o.base), log), name_of(of.pose(o.target), log));
}
template <int Dim>
std::string name_of(const FeatureFactor<Dim>& o, const Log<Dim>& log) {
  const TieVertices of = vertices_of(log);
  return fmt::format("{} from {}", name_of(of.feature(o.target), log), name_of(of.pose(o.base), log));
}

}  // namespace

double median_scale(const std::vector<WeighedResidual>& residuals) {
  ChiSquaredQuantiles medians(0.5);
  std::vector<double> ratios;
  for (const WeighedResidual& r : residuals) {
    if (r.rows > 0) ratios.push_back(r.chi2 / medians(r.rows));
  }
  if (ratios.empty()) return std::numeric_limits<double>::quiet_NaN();
  return median(std::move(ratios));
}

KindFit kind_fit(std::string kind, const std::vector<WeighedResidual>& residuals,
                 const std::function<std::string(std::size_t)>& name) {
  KindFit fit;
  fit.kind = std::move(kind);
  fit.count = residuals.size();
  fit.scale = median_scale(residuals);
  for (const WeighedResidual& residual : residuals) fit.rows += residual.rows;
  const double typical = fit.rows < kLeastRows ? 1.0 : std::max(1.0, fit.scale);
  ChiSquaredQuantiles most(1e-3 / static_cast<double>(std::max<std::size_t>(1, residuals.size())));
  std::vector<std::size_t> outliers;
  for (std::size_t i = 0; i < residuals.size(); ++i) {
    const auto& [chi2, rows] = residuals[i];
    fit.chi2 += chi2;
    fit.worst = std::max(fit.worst, chi2);
    if (rows > 0 && chi2 > typical * most(rows)) outliers.push_back(i);
  }
  const auto is_worse = [&](std::size_t a, std::size_t b) { return residuals[a].chi2 > residuals[b].chi2; };
  std::stable_sort(outliers.begin(), outliers.end(), is_worse);
  for (const std::size_t i : outliers) {
    fit.outliers.add(fmt::format("{} (chi2 {:.4g})", name(i), residuals[i].chi2));
  }
  return fit;
}

template <int Dim>
std::vector<KindFit> fits_of(const Log<Dim>& log, const Values<Dim>& state) {
  std::vector<KindFit> fits;
  const auto add = [&](const char* kind, const auto& all) {
    if (all.empty()) return;
    std::vector<WeighedResidual> residuals;
    for (const auto& o : all) residuals.push_back(weighed(o, state));
    fits.push_back(kind_fit(kind, residuals, [&](std::size_t i) { return name_of(all[i], log); }));
  };
  add("odometry", log.odometry());
  add("closures", log.closures());
  add("observations", log.observations());
  add("priors of poses", log.pose_priors());
  add("priors of features", log.feature_priors());
  return fits;
}

Findings check_fit(const std::vector<KindFit>& fits, std::int64_t dof) {
  Findings findings;
  double chi2 = 0.0;
  for (const KindFit& fit : fits) {
    chi2 += fit.chi2;
    if (fit.scale > kLarger * kLarger && fit.rows >= kLeastRows) {
      findings.push_back(
          {FindingLevel::kWarning,
           "too_certain",
           fmt::format("typical residuals of {} are {:.3g} times what the covariances say", fit.kind, std::sqrt(fit.scale)),
           {}});
    }
  }
  if (dof < kLeastRows || chi2 * kSmaller * kSmaller > static_cast<double>(dof)) return findings;
  findings.push_back({FindingLevel::kWarning,
                      "too_cautious",
                      fmt::format("residuals are {:.2g} of what the covariances say (chi2 {:.6g}, dof {})",
                                  std::sqrt(chi2 / static_cast<double>(dof)), chi2, dof),
                      {}});
  return findings;
}

Findings check_outliers(const std::vector<KindFit>& fits) {
  Findings findings;
  for (const KindFit& fit : fits) {
    add_if_any(findings,
               {FindingLevel::kWarning, "outliers",
                fmt::format("out of line with the map: {} of {} {}", fit.outliers.count, fit.count, fit.kind), fit.outliers});
  }
  return findings;
}

template std::vector<KindFit> fits_of(const Log<2>&, const Values<2>&);
template std::vector<KindFit> fits_of(const Log<3>&, const Values<3>&);

}  // namespace mapjoin
