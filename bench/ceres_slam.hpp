// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Full SLAM of a log by Ceres, as fast as it goes: with the library's analytic Jacobians, on one thread.

#include <ceres/types.h>

#include <limits>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/log.hpp>

namespace mapjoin::bench {

/// The loss against wrong closures and observations.
enum class CeresLoss : std::uint8_t {
  kPlain,         ///< None: least squares.
  kCauchy,        ///< ln(1 + s) of the squared whitened residual s.
  kGemanMcClure,  ///< s / (1 + s).
  kSwitchable,    ///< Switchable constraints: each residual times a variable of its own in [0, 1], with a prior of 1 ± 1.
};
constexpr auto enum_names(CeresLoss) {
  return std::to_array<EnumName<CeresLoss>>({{CeresLoss::kPlain, "plain"},
                                             {CeresLoss::kCauchy, "cauchy"},
                                             {CeresLoss::kGemanMcClure, "geman-mcclure"},
                                             {CeresLoss::kSwitchable, "switchable"}});
}

struct CeresOptions {
  ceres::LinearSolverType linear = ceres::SPARSE_NORMAL_CHOLESKY;
  ceres::TrustRegionStrategyType method = ceres::LEVENBERG_MARQUARDT;
  CeresLoss loss = CeresLoss::kPlain;
  int most_iterations = 1000;
  double most_seconds = std::numeric_limits<double>::max();
  double enough_chi2 = 0.0;  ///< The solve ends at the first chi2 that is no larger.
};

template <int Dim>
struct CeresResult {
  Values<Dim> values;
  int iterations = 0;
};

template <int Dim>
CeresResult<Dim> solve_by_ceres(const Log<Dim>& log, const Values<Dim>& start, const CeresOptions& options);

}  // namespace mapjoin::bench
