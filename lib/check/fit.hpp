// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Checks that residuals at a map are as large as the information matrices say, kind by kind.

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

/// The median ratio of chi2 to the median expected of it under correct covariances: 1, or less, since the map adapts itself to
/// the observations. Robust to outliers. NaN if nothing was measured.
double median_scale(const std::vector<WeighedResidual>& residuals);

/// The fit of observations of one kind to a map.
struct KindFit {
  std::string kind;  ///< "odometry", "closures", "observations", "priors of poses", "priors of features" or "local maps".
  std::size_t count = 0;
  std::int64_t rows = 0;
  double chi2 = 0.0;
  double scale = 0.0;  ///< Their median_scale().
  /// Outliers, the worst first: chi2 above what all observations of a kind of this size stay below in 999 of 1000 cases, even
  /// if all its covariances are too small by `scale`, which counts from 20 rows on.
  Places outliers;
  double worst = 0.0;  ///< The largest chi2.
};

/// The fit of one kind; `name(i)` names observation i.
KindFit kind_fit(std::string kind, const std::vector<WeighedResidual>& residuals,
                 const std::function<std::string(std::size_t)>& name);

/// The fits of all kinds of observations that the log has, at values of its poses and features.
template <int Dim>
std::vector<KindFit> fits_of(const Log<Dim>& log, const Values<Dim>& state);

/// Checks the sizes of residuals:
/// - `too_certain` (warning): a kind whose typical residual is more than 1.5 times what its covariances say.
/// - `too_cautious` (warning): all residuals together, at an optimum of `dof` degrees of freedom, are less than half of what
///   the covariances say. For a single kind only an upper bound of its chi2 is known there.
Findings check_fit(const std::vector<KindFit>& fits, std::int64_t dof);

/// Checks for outliers:
/// - `outliers` (warning): the outliers of a kind, at values that need not be an optimum (there goodness_of_fit() tells more).
Findings check_outliers(const std::vector<KindFit>& fits);

}  // namespace mapjoin
