// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// An independent reference optimiser: Ceres with automatic derivatives of the residual of model/factor.hpp. It has neither
// Jacobians, products of rotations nor normal equations in common with the library.

#include <mapjoin/model/log.hpp>
#include <mapjoin/model/submap_set.hpp>
#include <string>
#include <tests/support/starts.hpp>

namespace mapjoin::testing {

enum class ReferenceMethod { kLevenbergMarquardt, kDogleg };

struct ReferenceOptions {
  ReferenceMethod method = ReferenceMethod::kLevenbergMarquardt;
  int max_iterations = 500;
  double function_tolerance = 1e-13;  ///< The relative decrease of chi2 by a step below which it stops.
  bool verbose = false;               ///< Prints every iteration on stdout.
};

template <int Dim>
struct ReferenceResult {
  bool converged = false;
  int iterations = 0;
  double initial_chi2 = 0.0;  ///< chi2 at the start: the sum of squared Mahalanobis residuals, without a factor 1/2.
  double chi2 = 0.0;
  Values<Dim> values;
  std::string summary;  ///< Ceres' report of its run.
};

/// Minimises the chi2 of a log from `start`. Fixed poses are held; if neither a fixed pose nor a prior ties the log to the
/// World, pose 0 is held.
template <int Dim>
ReferenceResult<Dim> ceres_optimum(const Log<Dim>& log, const Values<Dim>& start, const ReferenceOptions& options = {});

/// Minimises the chi2 of a join of local maps from `start`. Fixed poses are held; if nothing ties the maps to the World, pose 0
/// is held.
template <int Dim>
ReferenceResult<Dim> ceres_optimum(const SubmapSet<Dim>& set, const Values<Dim>& start, const ReferenceOptions& options = {});

}  // namespace mapjoin::testing
