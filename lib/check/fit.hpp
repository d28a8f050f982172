// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks of whether residuals at a map are as large as the information matrices say, kind by kind.

#include <cstdint>
#include <functional>
#include <mapjoin/check/checks.hpp>
#include <mapjoin/model/log.hpp>
#include <mapjoin/model/values.hpp>
#include <string>
#include <vector>

namespace mapjoin {

/// An observation's squared Mahalanobis residual rᵀWr and the rank of W.
struct WeighedResidual {
  double chi2 = 0.0;
  std::int64_t rows = 0;
};

/// The median of chi2 over the median that it has where the covariances are right: 1, or less, for the map adapts itself to
/// the observations. Outliers do not move it. NaN where nothing was measured.
double median_scale(const std::vector<WeighedResidual>& residuals);

/// How observations of one kind fit a map.
struct KindFit {
  std::string kind;  ///< "odometry", "closures", "observations", "priors of poses", "priors of features" or "local maps".
  std::size_t count = 0;
  std::int64_t rows = 0;
  double chi2 = 0.0;
  double scale = 0.0;  ///< The median_scale() of them.
  /// Observations whose chi2 no kind of so many would reach in 999 of 1000 cases, be all its covariances too small by `scale`;
  /// the worst first.
  Places outliers;
  double worst = 0.0;  ///< The largest chi2.
};

/// `name(i)` names observation i.
KindFit kind_fit(std::string kind, const std::vector<WeighedResidual>& residuals,
                 const std::function<std::string(std::size_t)>& name);

/// The kinds that the log has, at poses and features of its own.
template <int Dim>
std::vector<KindFit> fits_of(const Log<Dim>& log, const Values<Dim>& state);

/// - `too_certain` (warning): a kind whose typical residual is more than 1.5 times what its covariances say;
/// - `too_cautious` (warning): all residuals together, at an optimum of `dof` degrees of freedom, are less than half of what
///   they say. What a kind alone should come to there is known from above only.
Findings check_fit(const std::vector<KindFit>& fits, std::int64_t dof);

/// - `outliers` (warning): those of a kind that do not fit, at values that need not be an optimum: there, goodness_of_fit()
/// tells
///   better.
Findings check_outliers(const std::vector<KindFit>& fits);

}  // namespace mapjoin
