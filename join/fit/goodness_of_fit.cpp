// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <functional>
#include <map>
#include <mapjoin/join/fit/goodness_of_fit.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/parallel/parallel.hpp>
#include <span>
#include <vector>

namespace mapjoin {
namespace {

/// The significance level of the test of chi2 as a whole, and of the tests of all parts together.
constexpr double kLevel = 0.01 / 2;
/// The sum of redundancies, in whole parts, from which on the scale of a kind is trusted: the odometry of one long loop has the
/// redundancy of one edge.
constexpr double kLeastParts = 20.0;
/// The rotation of a pose (rad), on leaving a part out, beyond which Jacobians change by a tenth: the other parts are then
/// tested only in a map without it.
constexpr double kFarFromOptimum = 0.1;

/// A part that can be tested, and the result of its test.
struct TestedPart {
  PartKind kind = PartKind::kClosure;
  MeasuredPart part;
  PartTest test;
};

template <int Dim>
using System = JoiningSystem<Dim>;

template <int Dim>
PartKind kind_of(const PoseFactor<Dim>& factor, std::span<const PoseFactor<Dim>> odometry) {
  if (factor.base == kWorld) return PartKind::kPrior;
  const std::less<> before;
  const bool is_odometry = !odometry.empty() && !before(&factor, odometry.data()) && !before(&odometry.back(), &factor);
  return is_odometry ? PartKind::kOdometry : PartKind::kClosure;
}

/// The parts to test: whole factors, and the features of local maps.
template <int Dim>
std::vector<TestedPart> parts_of(const System<Dim>& system, std::size_t factors, std::span<const PoseFactor<Dim>> odometry) {
  std::vector<TestedPart> parts;
  for (std::size_t k = 0; k < factors; ++k) {
    const MeasuredPart whole{k, 0, system.rows(k)};
    const auto [source, place] = system.source_of(k);
    if (source == System<Dim>::Source::kPoseFactor) {
      parts.push_back({kind_of(*system.pose_factors()[place].observation, odometry), whole, {}});
    } else if (source == System<Dim>::Source::kFeatureFactor) {
      const bool is_prior = system.feature_factors()[place].observation->base == kWorld;
      parts.push_back({is_prior ? PartKind::kPrior : PartKind::kObservation, whole, {}});
    } else {
      const LocalMap<Dim>& map = *system.maps()[place].map;
      parts.push_back({PartKind::kLocalMap, whole, {}});
      for (std::size_t f = 0; f < map.features.size(); ++f) {
        parts.push_back({PartKind::kMapFeature, {k, map.row(map.poses.size() + f), Dim}, {}});
      }
    }
  }
  return parts;
}

/// Solves for closures and priors that others hardly confirm, as one alone may close a long loop, and for observations and
/// odometry that are confirmed by less than rounding shows.
template <int Dim>
void solve_for_weak(LeaveOneOut<Dim>& leave_one_out, const std::vector<TestedPart>& parts, const std::stop_token& stop) {
  std::vector<std::size_t> factors;
  for (const auto& [kind, part, test] : parts) {
    const bool may_close_a_loop = kind == PartKind::kClosure || kind == PartKind::kPrior;
    const bool is_of_map = kind == PartKind::kMapFeature || kind == PartKind::kLocalMap;  // with a hundred rows or more
    if (may_close_a_loop || (!is_of_map && leave_one_out.is_rounded(part.factor))) factors.push_back(part.factor);
  }
  leave_one_out.solve_for_weak(factors, stop);
}

/// Tests all parts, and drops those that nothing else confirms.
template <int Dim>
void test_parts(const LeaveOneOut<Dim>& leave_one_out, std::vector<TestedPart>& parts) {
  parallel_chunks(parts.size(), kObservationsPerPiece, [&](std::size_t begin, std::size_t end) {
    for (std::size_t k = begin; k < end; ++k) parts[k].test = leave_one_out.test(parts[k].part);
  });
  std::erase_if(parts, [](const TestedPart& part) { return part.test.rows == 0; });
}

/// The scales of the kinds that are present.
std::vector<KindScale> scales_of(const std::vector<TestedPart>& parts) {
  ChiSquaredQuantiles medians(0.5);
  std::map<PartKind, std::vector<Weighted>> ratios;  // of chi2 to its median if the covariances were right
  for (const auto& [kind, part, test] : parts) {
    ratios[kind].push_back({test.chi2 / medians(test.rows), test.redundancy / test.rows});
  }
  std::vector<KindScale> scales;
  for (auto& [kind, of_kind] : ratios) {
    KindScale& scale = scales.emplace_back(KindScale{kind, of_kind.size()});
    for (const Weighted& ratio : of_kind) scale.confirmed += ratio.weight;
    scale.scale = weighted_median(std::move(of_kind));
  }
  return scales;
}

bool is_trusted(const KindScale& kind) {
  return kind.confirmed >= kLeastParts;
}

/// The scale of a kind that is trusted, at least 1, so that the given covariances are the strictest; else 1.
double trusted_scale(const KindScale& kind) {
  return is_trusted(kind) ? std::max(1.0, kind.scale) : 1.0;
}

/// The scale that a part is judged against: that of its kind. Of a kind that is hardly confirmed the part's own error counts as
/// given, and what the others add to its chi2, a share of 1 - redundancy, by the scale of the kind that is confirmed most.
double tolerated_scale(const std::vector<KindScale>& scales, const TestedPart& part) {
  const auto own = std::ranges::find(scales, part.kind, &KindScale::kind);  // every tested kind has one
  if (is_trusted(*own)) return trusted_scale(*own);
  const double of_others = trusted_scale(*std::ranges::max_element(scales, {}, &KindScale::confirmed));
  const double redundancy = part.test.redundancy / part.test.rows;
  return redundancy + (1.0 - redundancy) * of_others;
}

template <int Dim>
Misfit misfit_of(const TestedPart& part, double scale, double probability, const Restored<Dim>& restored) {
  const System<Dim>& system = restored.system;
  const auto [source, place] = system.source_of(part.part.factor);
  Misfit misfit{part.kind, kWorld, PoseIndex(), part.test.chi2 / scale, part.test.rows, probability};
  const auto take = [&](const auto& factor) { misfit.from = factor.base, misfit.to = factor.target; };
  if (source == System<Dim>::Source::kPoseFactor) {
    take(*system.pose_factors()[place].observation);
  } else if (source == System<Dim>::Source::kFeatureFactor) {
    take(*system.feature_factors()[place].observation);
  } else {
    const LocalMap<Dim>& map = *system.maps()[place].map;
    misfit.from = map.base;
    misfit.to = map.poses.empty() ? map.base : map.poses.back();
    if (part.kind == PartKind::kMapFeature) {
      misfit.to = map.features[static_cast<std::size_t>((part.part.row - map.row(map.poses.size())) / Dim)];
    }
  }
  return misfit;
}

/// The share of its chi2 that a part is blamed for. An odometry edge of a loop with one closure fits as badly as that closure,
/// which is the likelier culprit; if two closures of equal certainty agree against the edge, each of them fits less than half
/// as badly. A local map with one feature under a wrong name fits a little worse than that feature.
double blame(PartKind kind) {
  return kind == PartKind::kOdometry || kind == PartKind::kLocalMap ? 0.5 : 1.0;
}

/// The part to leave out next: the one most to blame among those that chance hardly explains; null if there is none.
const TestedPart* worst_of(const std::vector<TestedPart>& parts, const std::vector<KindScale>& scales) {
  ChiSquaredQuantiles most_by_chance(kLevel / static_cast<double>(parts.size()));
  const TestedPart* worst = nullptr;
  double least = 0.0;
  for (const TestedPart& part : parts) {
    const int rows = part.test.rows;
    const double chi2 = part.test.chi2 / tolerated_scale(scales, part);
    if (chi2 <= most_by_chance(rows)) continue;
    const double log_probability = log_chi_squared_upper_tail(blame(part.kind) * chi2, rows);
    if (log_probability < least) worst = &part, least = log_probability;
  }
  return worst;
}

/// Leaves out the parts that do not fit, the worst first. Returns true if no misfit is left.
template <int Dim>
bool find_misfits(const Restored<Dim>& restored, LeaveOneOut<Dim>& leave_one_out, std::vector<TestedPart>& parts,
                  std::size_t most_misfits, const std::stop_token& stop, GoodnessOfFit& fit) {
  while (const TestedPart* worst = worst_of(parts, fit.kinds)) {
    if (fit.misfits.size() == most_misfits || stop.stop_requested()) return false;
    const auto [kind, part, test_of_part] = *worst;
    const double scale = tolerated_scale(fit.kinds, *worst);
    const double probability =
        static_cast<double>(parts.size()) * chi_squared_upper_tail(test_of_part.chi2 / scale, test_of_part.rows);
    fit.misfits.push_back(misfit_of(*worst, scale, probability, restored));
    fit.chi2 -= test_of_part.chi2;
    fit.dof -= test_of_part.rows;
    if (leave_one_out.leave_out(part) > kFarFromOptimum) return false;
    parts.erase(parts.begin() + (worst - parts.data()));
    test_parts(leave_one_out, parts);
    fit.kinds = scales_of(parts);
  }
  return true;
}

/// Marks the kinds with the largest residuals; those of other kinds suffer from theirs. Kinds that are hardly confirmed count
/// only if all are.
void mark_too_certain(std::vector<KindScale>& scales) {
  const bool any_is_trusted = std::ranges::any_of(scales, is_trusted);
  const auto counts = [&](const KindScale& kind) { return is_trusted(kind) || !any_is_trusted; };
  double largest = 0.0;
  for (const KindScale& kind : scales) largest = counts(kind) ? std::max(largest, kind.scale) : largest;
  for (KindScale& kind : scales) kind.is_too_certain = counts(kind) && kind.scale > 1.0 && 2.0 * kind.scale > largest;
}

}  // namespace

template <int Dim>
GoodnessOfFit goodness_of_fit(const Restored<Dim>& restored, const NormalEquations& equations, const Marginals& marginals,
                              std::int64_t dof, std::span<const PoseFactor<Dim>> odometry, std::size_t most_misfits,
                              const std::stop_token& stop) {
  LeaveOneOut<Dim> leave_one_out(restored.system, equations, marginals);
  std::vector<TestedPart> parts = parts_of(restored.system, equations.pattern().factors.size(), odometry);
  solve_for_weak(leave_one_out, parts, stop);
  test_parts(leave_one_out, parts);
  GoodnessOfFit fit;
  fit.chi2 = leave_one_out.chi2();
  fit.dof = dof;
  fit.parts = parts.size();
  fit.kinds = scales_of(parts);
  if (fit.parts == 0) return fit;
  fit.is_complete = find_misfits(restored, leave_one_out, parts, most_misfits, stop, fit);
  fit.probability = chi_squared_upper_tail(fit.chi2, static_cast<double>(fit.dof));
  if (fit.probability < kLevel) mark_too_certain(fit.kinds);
  const bool fits = fit.is_complete && fit.misfits.empty() && fit.probability >= kLevel;
  fit.verdict = fits ? Verdict::kFits : Verdict::kMisfit;
  return fit;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                       \
  template GoodnessOfFit goodness_of_fit(const Restored<Dim>&, const NormalEquations&, const Marginals&, std::int64_t, \
                                         std::span<const PoseFactor<Dim>>, std::size_t, const std::stop_token&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
