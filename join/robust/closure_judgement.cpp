// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>
#include <mapjoin/join/robust/closure_judgement.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/linearise.hpp>

namespace mapjoin {
namespace {

template <int Dim>
double squared_distance(const UncertainPose<Dim>& mismatch) {
  const PoseVector<Dim> v = local(Pose<Dim>{}, mismatch.mean);
  const Eigen::LLT<PoseMatrix<Dim>> covariance(mismatch.covariance);
  return covariance.info() == Eigen::Success ? v.dot(covariance.solve(v)) : std::numeric_limits<double>::max();
}

/// Turns a relative pose from base to target into the one from the earlier to the later end of a closure, or back.
template <int Dim>
Pose<Dim> turned_forward(const PoseFactor<Dim>& closure, const Pose<Dim>& relative) {
  return closure.base < closure.target ? relative : inverse(relative);
}

/// The number of measured relative poses, turned forward, that would pass a gate in the place of a closure whose mismatch has
/// this covariance; at most `most`, and `most` if the covariance is singular.
template <int Dim>
std::size_t count_within(const std::vector<Pose<Dim>>& measured, const PoseFactor<Dim>& closure, const Values<Dim>& values,
                         const PoseMatrix<Dim>& covariance, double gate, std::size_t most) {
  const Eigen::LLT<PoseMatrix<Dim>> factor(covariance);
  if (factor.info() != Eigen::Success) return most;  // what would fit is unknown
  std::size_t count = 0;
  for (auto other = measured.begin(); other != measured.end() && count < most; ++other) {
    const Pose<Dim> along = turned_forward(closure, *other);
    const PoseVector<Dim> v = residual<Dim>(along, values.poses[closure.base], values.poses[closure.target]);
    if (v.dot(factor.solve(v)) < gate) ++count;
  }
  return count;
}

}  // namespace

template <int Dim>
ClosureJudgement<Dim> judge(const Log<Dim>& log, const std::vector<std::size_t>& chosen, const TruncatedJoin<Dim>& join,
                            const Gates& gates, const std::stop_token& stop) {
  const std::size_t count = log.closures().size();
  ClosureJudgement<Dim> judged{std::vector(count, Standing::kOpen), std::vector(count, 0.0),
                               std::vector<UncertainPose<Dim>>(count), join.system().estimate()};
  for (std::size_t c = 0; c < chosen.size(); ++c) {
    if (join.counts(c)) judged.standing[chosen[c]] = Standing::kKept;
  }
  std::vector<std::size_t> others;
  std::vector<PoseFactor<Dim>> closures;
  for (std::size_t k = 0; k < count; ++k) {
    if (judged.standing[k] == Standing::kKept) continue;
    others.push_back(k);
    closures.push_back(log.closures()[k]);
  }
  const std::vector<UncertainPose<Dim>> mismatches =
      mapjoin::mismatches<Dim>(join.system(), join.marginals(), closures, gates.widest.closures, stop);
  for (std::size_t c = 0; c < others.size(); ++c) {
    judged.mismatches[others[c]] = mismatches[c];
    judged.chi2[others[c]] = squared_distance(mismatches[c]);
  }
  for (std::size_t c = 0; c < chosen.size(); ++c) judged.chi2[chosen[c]] = join.closure_tests()[c].chi2;
  for (const std::size_t k : others) {
    if (judged.chi2[k] >= gates.narrow().closures) judged.standing[k] = Standing::kDropped;
  }
  return judged;
}

template <int Dim>
std::vector<bool> fits_beyond_chance(const ClosureJudgement<Dim>& judgement, std::span<const PoseFactor<Dim>> closures,
                                     const Gates& gates) {
  const std::vector<double>& chi2 = judgement.chi2;
  const double widest = gates.widest.closures;
  std::vector<Pose<Dim>> contradicted;
  for (std::size_t k = 0; k < closures.size(); ++k) {
    if (chi2[k] >= widest) contradicted.push_back(turned_forward(closures[k], closures[k].measured));
  }
  const auto would_be_within = [&](double gate, std::size_t k, std::size_t most) {
    if (contradicted.empty()) return std::size_t{0};
    return count_within(contradicted, closures[k], judgement.values, judgement.mismatches[k].covariance, gate, most);
  };
  std::vector<bool> fits(closures.size());
  std::vector<std::size_t> open;  // between the gates, and not kept
  std::size_t right = 0;          // number between the gates that are taken as right
  for (std::size_t k = 0; k < closures.size(); ++k) {
    const bool is_kept = judgement.standing[k] == Standing::kKept;
    fits[k] = is_kept || chi2[k] < gates.narrow().closures;
    if (chi2[k] < gates.narrow().closures || chi2[k] >= widest) continue;
    if (is_kept || would_be_within(widest, k, 1) == 0) ++right;
    if (!is_kept) open.push_back(k);
  }
  const std::size_t most = std::max<std::size_t>(1, right);
  const auto most_so_near = static_cast<std::size_t>(whole_part((1.0 - gates.confidence) * static_cast<double>(right)));
  for (const std::size_t k : open) {
    fits[k] = would_be_within(widest, k, most) < most || would_be_within(chi2[k], k, most_so_near) < most_so_near;
  }
  return fits;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                    \
  template ClosureJudgement<Dim> judge(const Log<Dim>&, const std::vector<std::size_t>&, const TruncatedJoin<Dim>&, \
                                       const Gates&, const std::stop_token&);                                       \
  template std::vector<bool> fits_beyond_chance(const ClosureJudgement<Dim>&, std::span<const PoseFactor<Dim>>, const Gates&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
