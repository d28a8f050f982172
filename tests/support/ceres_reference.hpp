// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The independent optimiser: Ceres with automatic derivatives on the residual of model/factor.hpp, sharing neither
// Jacobians, rotations nor normal equations with the library.

#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <tests/support/starts.hpp>

namespace mapjoin::testing {

enum class ReferenceMethod { kLevenbergMarquardt, kDogleg };

struct ReferenceOptions {
  ReferenceMethod method = ReferenceMethod::kLevenbergMarquardt;
  int max_iterations = 500;
  double function_tolerance = 1e-13;  ///< Relative; it stops where a step gains less.
  bool verbose = false;               ///< Every iteration on stdout.
};

template <int Dim>
struct ReferenceResult {
  bool converged = false;
  int iterations = 0;
  double initial_chi2 = 0.0;  ///< Sums of squared Mahalanobis residuals, no factor 1/2.
  double chi2 = 0.0;
  Values<Dim> values;
  std::string summary;  ///< What Ceres says of its run.
};

/// The least chi2 that Ceres finds from `start`. Fixed poses are held; where neither a fixed pose nor a prior ties the log to
/// the World, pose 0 is.
template <int Dim>
ReferenceResult<Dim> ceres_optimum(const Log<Dim>& log, const Values<Dim>& start, const ReferenceOptions& options = {});

/// The same for maps to be joined.
template <int Dim>
ReferenceResult<Dim> ceres_optimum(const SubmapSet<Dim>& set, const Values<Dim>& start, const ReferenceOptions& options = {});

}  // namespace mapjoin::testing
