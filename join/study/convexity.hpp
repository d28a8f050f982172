// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// How far from convex, and how far from linear, are full SLAM and joining, in absolute and in relative coordinates (paper's
// IV.A, Fig. 4, and V, VI)?

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
  SplitOptions split;                      ///< Of a log into the local maps that are joined.
  StateSource source = StateSource::kBox;  ///< Of the random pairs of states.
  double spread = 1.0;                     ///< Of StateSource::kDrift.
  bool to_best = false;                    ///< Y is the best estimate in every pair, not another random state.
  std::size_t pairs = 5;
  std::size_t points = 101;  ///< Values of λ per pair.
  std::uint64_t seed = 1;
  /// Called with the segments done and to do; from one thread at a time.
  std::function<void(std::size_t, std::size_t)> progress;

  /// Every violation in words; empty if there is none.
  std::vector<std::string> validate() const;
};

/// F between one pair of states.
struct LineOfStates {
  std::vector<double> values;  ///< F(λX + (1-λ)Y) at equally spaced λ, from Y to X.
  CurvatureFigures curvature;
};

/// What one Gauss-Newton step from the composed start achieves.
struct FirstStep {
  double start_chi2 = 0.0;
  double chi2 = std::numeric_limits<double>::quiet_NaN();  ///< After it; not a number where the system was singular.
  double best_chi2 = 0.0;                                  ///< Of the default method.

  /// Of the whole decrease from start to best; negative where the step makes it worse. Nothing where the start is as good as
  /// the best.
  std::optional<double> share() const;
};

struct FormulationFigures {
  Formulation formulation;
  std::vector<LineOfStates> segments;
  CurvatureFigures curvature;  ///< Over all segments.
  QuadraticShare quadratic;    ///< At the best estimate.
  FirstStep first_step;
};

/// By formulation, in the order of kFormulations.
using Convexity = std::vector<FormulationFigures>;

/// All four formulations of a log; the pairs of states are the same for all, for joining what is joined of them. In parallel,
/// with the same result for any number of threads. Bad input as run(); kTooLarge where the covariances for QuadraticShare are
/// more than the machine can hold; kInterrupted on `stop`. Throws std::invalid_argument with the first violation of `options`.
template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const ConvexityOptions& options, const std::stop_token& stop = {});

/// As before, from local maps already built: `split` and `maps` as build_local_maps left them.
template <int Dim>
Expected<Convexity> convexity(const Log<Dim>& log, const Split& split, const std::vector<LocalMap<Dim>>& maps,
                              const ConvexityOptions& options, const std::stop_token& stop = {});

/// The two formulations of joining, of local maps of which nothing else is known.
template <int Dim>
Expected<Convexity> convexity(const SubmapSet<Dim>& set, const ConvexityOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
