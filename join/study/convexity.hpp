// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The convexity and the linearity of full SLAM and joining, in absolute and in relative coordinates (paper's IV.A, Fig. 4, and
// V, VI).

#include <cstdint>
#include <functional>
#include <limits>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/study/convexity_objective.hpp>
#include <mapjoin/join/study/convexity_pairs.hpp>
#include <mapjoin/join/study/formulation.hpp>
#include <mapjoin/measure/curvature.hpp>
#include <optional>
#include <stop_token>
#include <string>
#include <vector>

namespace mapjoin {

struct ConvexityOptions {
  SplitOptions split;                      ///< Split of a log into the local maps that are joined.
  StateSource source = StateSource::kBox;  ///< Source of the random pairs of states.
  double spread = 1.0;                     ///< Factor on the errors of StateSource::kDrift.
  bool to_best = false;                    ///< True if Y is the best estimate in every pair, not another random state.
  std::size_t pairs = 5;
  std::size_t points = 101;  ///< Values of λ per pair.
  std::uint64_t seed = 1;
  /// Called with the segments done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// The objective F between one pair of states.
struct LineOfStates {
  std::vector<double> values;  ///< F(λX + (1-λ)Y) at equally spaced λ, from Y to X.
  CurvatureFigures curvature;
};

/// The effect of one Gauss-Newton step from the composed start.
struct FirstStep {
  double start_chi2 = 0.0;
  double chi2 = std::numeric_limits<double>::quiet_NaN();  ///< chi2 after the step; NaN if the system was singular.
  double best_chi2 = 0.0;                                  ///< chi2 by the default method.

  /// The share of the step in the decrease from start to best; negative if chi2 grows. nullopt if the start is as good as the
  /// best, or the system was singular.
  std::optional<double> share() const;
};

struct FormulationFigures {
  Formulation formulation;
  std::size_t maps = 0;  ///< Number of local maps that are joined; 0 for full SLAM.
  std::vector<LineOfStates> segments;
  CurvatureFigures curvature;  ///< Curvature over all segments.
  QuadraticShare quadratic;    ///< Quadratic share at the best estimate.
  FirstStep first_step;
};

/// The figures by formulation, in the order of kFormulations.
using Convexity = std::vector<FormulationFigures>;

/// The figures of all four formulations of a log. The pairs of states are the same for all; joining takes the part of them that
/// it joins. Runs in parallel, with the same result for any number of threads. Bad input as run(), and if a prior has a lever;
/// kTooLarge if the covariances for QuadraticShare exceed the memory of the machine; kInterrupted on `stop`. Throws
/// std::invalid_argument with the first violation of `options`.
template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const ConvexityOptions& options, const std::stop_token& stop = {});

/// The figures of a log from local maps already built: `split` and `maps` are as build_local_maps left them. Otherwise as of a
/// log alone.
template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps,
                              const ConvexityOptions& options, const std::stop_token& stop = {});

/// The figures of the two formulations of joining, of local maps without their log. Errors as of a log.
template <int Dim>
Expected<Convexity> convexity(const SubmapSet<Dim>& set, const ConvexityOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
