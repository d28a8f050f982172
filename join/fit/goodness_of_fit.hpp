// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Does a map fit its measurements? Tests of chi2 as a whole and of every part, and a verdict.

#include <cstdint>
#include <mapjoin/join/fit/leave_one_out.hpp>
#include <mapjoin/join/restored.hpp>
#include <mapjoin/model/enum_names.hpp>
#include <mapjoin/model/ids.hpp>
#include <span>
#include <stop_token>
#include <vector>

namespace mapjoin {

enum class Verdict : std::uint8_t {
  kFits,         ///< Nothing is out of line with the covariances.
  kMisfit,       ///< Some part, or chi2 as a whole, is.
  kUntested,     ///< Nothing is measured twice, so that nothing could have been out of line; or the test was left out.
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
  kPrior,       ///< Of a pose or a feature.
  kMapFeature,  ///< A feature of a local map.
  kLocalMap,    ///< The whole of one.
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

/// A part that does not agree with the others.
struct Misfit {
  PartKind kind = PartKind::kClosure;
  PoseIndex from = kWorld;  ///< The base of the observation or local map.
  PoseOrFeature to;         ///< Its target; of a whole local map the end pose.
  double chi2 = 0.0;  ///< By what chi2 falls where the part is left out, with those before it; over the scale of its kind.
  int rows = 0;
  double probability = 0.0;  ///< Of so large a chi2 in any of the parts, were all as certain as their kind.
};

/// How large the residuals of one kind of parts are.
struct KindScale {
  PartKind kind = PartKind::kClosure;
  std::size_t parts = 0;   ///< Those that can be tested.
  double confirmed = 0.0;  ///< The sum of their redundancies, each as a share of its rows.
  /// The median of the parts' leave-one-out chi2, over what it would be were the covariances right. Outliers hardly move it.
  double scale = 1.0;
  bool is_too_certain = false;  ///< chi2 is too large, without the misfits, too, and this kind has a share in it.
};

struct GoodnessOfFit {
  Verdict verdict = Verdict::kUntested;
  double chi2 = 0.0;         ///< At the optimum without the misfits.
  std::int64_t dof = 0;      ///< The degrees of freedom of that chi2.
  double probability = 1.0;  ///< Of a larger chi2.
  std::size_t parts = 0;     ///< That could be tested.
  std::vector<KindScale> kinds;
  std::vector<Misfit> misfits;  ///< The worst first, each without those before it.
  bool is_complete = true;      ///< There are no other misfits: else more may show in a map without these.
};

/// Tests a map at the estimate of `restored`, whose normal equations, linearised and factorised there, are `equations`; `dof`
/// are the degrees of freedom of its chi2, `odometry` the odometry of its log, if it has one. What fits is called a misfit in
/// one of a hundred cases: half of that is spent on chi2 as a whole, the other half, by Holm's correction, on all parts
/// together. At most `most_misfits` are named, and none once a stop is requested. Residuals of a kind whose typical ones are
/// larger than its covariances say are judged against that scale.
template <int Dim>
GoodnessOfFit goodness_of_fit(const Restored<Dim>& restored, const NormalEquations& equations, const Marginals& marginals,
                              std::int64_t dof, std::span<const PoseFactor<Dim>> odometry, std::size_t most_misfits,
                              const std::stop_token& stop = {});

}  // namespace mapjoin
