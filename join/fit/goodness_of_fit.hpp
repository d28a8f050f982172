// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The goodness of fit of a map to its measurements: tests of chi2 as a whole and of every part, and a verdict.

#include <cstdint>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/model/conventions.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/ids.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

enum class Verdict : std::uint8_t {
  kFits,         ///< Nothing is out of line with the covariances.
  kMisfit,       ///< Some part, or chi2 as a whole, is out of line with the covariances.
  kUntested,     ///< Nothing is measured twice, so that nothing could be out of line; or the test was left out.
  kUnconverged,  ///< The map is no optimum: residuals tell nothing.
};
constexpr auto enum_names(Verdict) {
  return std::to_array<EnumName<Verdict>>({{Verdict::kFits, "fits"},
                                           {Verdict::kMisfit, "misfit"},
                                           {Verdict::kUntested, "untested"},
                                           {Verdict::kUnconverged, "unconverged"}});
}

/// The kinds of parts that are tested.
enum class PartKind : std::uint8_t {
  kClosure,
  kObservation,
  kPrior,       ///< A prior of a pose or a feature.
  kMapFeature,  ///< A feature of a local map.
  kLocalMap,    ///< A local map as a whole.
  kOdometry,
};
constexpr auto enum_names(PartKind) {
  return std::to_array<EnumName<PartKind>>({{PartKind::kClosure, "closure"},
                                            {PartKind::kObservation, "observation"},
                                            {PartKind::kPrior, "prior"},
                                            {PartKind::kMapFeature, "feature of a map"},
                                            {PartKind::kLocalMap, "local map"},
                                            {PartKind::kOdometry, "odometry"}});
}

/// The factor of an Inflation that is of a kind of parts.
constexpr double Inflation::*inflation_of_kind(PartKind kind) {
  switch (kind) {
    case PartKind::kClosure:
      return &Inflation::closures;
    case PartKind::kOdometry:
      return &Inflation::odometry;
    case PartKind::kObservation:
      return &Inflation::observations;
    case PartKind::kPrior:
      return &Inflation::priors;
    case PartKind::kMapFeature:
    case PartKind::kLocalMap:
      break;
  }
  return &Inflation::maps;
}

/// A part that does not agree with the others.
struct Misfit {
  PartKind kind = PartKind::kClosure;
  PoseIndex from = kWorld;  ///< The base of the observation or local map.
  PoseOrFeature to;         ///< Target of the observation; for a whole local map its end pose.
  double chi2 = 0.0;        ///< Decrease of chi2 on leaving the part out after those before it, over the scale it is judged by.
  int rows = 0;
  double probability =
      0.0;  ///< Probability of so large a chi2 in any of the parts, if all were as certain as they are judged by.
};

/// The size of the residuals of one kind of parts, without the misfits (but the last, where the list is incomplete).
struct KindScale {
  PartKind kind = PartKind::kClosure;
  std::size_t parts = 0;   ///< Parts that can be tested.
  double confirmed = 0.0;  ///< Sum of the parts' redundancies, each as a share of the part's rows.
  /// The median of the parts' leave-one-out chi2, over its median if the covariances were right, where each part weighs as much
  /// as it is confirmed; robust against outliers.
  double scale = 1.0;
  bool is_too_certain = false;  ///< True if chi2 is too large, even without the misfits, and this kind has a share in it.
};

struct GoodnessOfFit {
  Verdict verdict = Verdict::kUntested;
  double chi2 = 0.0;         ///< chi2 at the optimum without the misfits.
  std::int64_t dof = 0;      ///< Degrees of freedom of `chi2`.
  double probability = 1.0;  ///< Probability of a larger chi2.
  std::size_t parts = 0;     ///< Parts that could be tested.
  std::vector<KindScale> kinds;
  std::vector<Misfit> misfits;  ///< Misfits, the worst first, each tested without those before it.
  bool is_complete = true;      ///< True if there are no other misfits; otherwise more may show in a map without these.
};

/// Tests a map at the estimate of `restored`, whose normal equations, linearised and factorised there, are `equations`; `dof`
/// are the degrees of freedom of its chi2, `odometry` is that of its log, empty without a log. A map that fits is called a
/// misfit in one of a hundred cases: half of this level is spent on chi2 as a whole, the other half, by Holm's correction, on
/// all parts together. At most `most_misfits` are named, and no more once a stop is requested, nor is anything solved for then
/// (LeaveOneOut::solve_for_weak()). If the typical residuals of a kind are larger than its covariances say, all of the kind are
/// judged against that scale; of a kind that hardly anything confirms, what others add to a residual is judged against the
/// scale of the kind that is confirmed most.
template <int Dim>
GoodnessOfFit goodness_of_fit(const Restored<Dim>& restored, const NormalEquations& equations, const Marginals& marginals,
                              std::int64_t dof, std::span<const PoseFactor<Dim>> odometry, std::size_t most_misfits,
                              const std::stop_token& stop = {});

}  // namespace mapjoin
