// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/robust/closure_judgement.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/linearise.hpp>
#include <numeric>

namespace mapjoin {
namespace {

/// The number of contradicted closures that tell how often wrong ones fit by chance.
constexpr std::size_t kMostSampled = 256;

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

/// The closures beyond the widest gate: what they measured may be wrong, and might have been measured elsewhere.
template <int Dim>
class Contradicted {
 public:
  Contradicted(const ClosureJudgement<Dim>& judgement, std::span<const PoseFactor<Dim>> closures, double widest)
      : judgement_(judgement), closures_(closures), gate_(widest) {
    for (std::size_t k = 0; k < closures.size(); ++k) {
      if (judgement.chi2[k] >= widest) all_.push_back(k);
    }
    const std::size_t apart = (all_.size() + kMostSampled - 1) / kMostSampled;
    for (std::size_t k = 0; k < all_.size(); k += apart) sample_.push_back(all_[k]);
  }

  /// The number of contradicted measurements that would pass the gate in the place of a closure, its own apart; at most `most`.
  std::size_t count_fitting(std::size_t place, std::size_t most) const { return count_fitting(place, all_, most); }
  /// The same among a sample of them.
  double count_sampled(std::size_t place) const { return static_cast<double>(count_fitting(place, sample_, sample_.size())); }

  /// A bound, with this confidence, on the number of wrong closures that are to be expected within the gate by chance, by how
  /// many of a sample would pass in the places of others. These have the largest covariances that they could have, which makes
  /// it larger.
  double expected_by_chance(double confidence) const {
    double fitting = 0.0;
    for (const std::size_t place : sample_) fitting += count_sampled(place);
    const auto sampled = static_cast<double>(sample_.size());
    const double most = 0.5 * chi_squared_upper_quantile(1.0 - confidence, 2 * (static_cast<int>(fitting) + 1));  // Poisson
    return static_cast<double>(all_.size()) * most / std::max(1.0, sampled * (sampled - 1.0));
  }

 private:
  /// `most` if the covariance of the mismatch is singular, as then nobody knows.
  std::size_t count_fitting(std::size_t place, const std::vector<std::size_t>& measured, std::size_t most) const {
    if (measured.empty()) return 0;
    const Eigen::LLT<PoseMatrix<Dim>> covariance(judgement_.mismatches[place].covariance);
    if (covariance.info() != Eigen::Success) return most;
    const PoseFactor<Dim>& closure = closures_[place];
    const auto& poses = judgement_.values.poses;
    std::size_t count = 0;
    for (auto other = measured.begin(); other != measured.end() && count < most; ++other) {
      const Pose<Dim> along = turned_forward(closure, turned_forward(closures_[*other], closures_[*other].measured));
      const PoseVector<Dim> v = residual<Dim>(along, poses[closure.base], poses[closure.target]);
      if (*other != place && v.dot(covariance.solve(v)) < gate_) ++count;
    }
    return count;
  }

  const ClosureJudgement<Dim>& judgement_;
  std::span<const PoseFactor<Dim>> closures_;
  double gate_;
  std::vector<std::size_t> all_;
  std::vector<std::size_t> sample_;  // evenly spaced
};

/// Flags closures within the gate, given from the nearest on, that are wrong with a probability of no more than the confidence
/// allows. Wrong ones lie anywhere in the gate, so that few are near, and rather where more contradicted measurements would
/// fit: as far out as all closures are, taken together, and then those that are so each.
template <int Dim>
std::vector<bool> hardly_wrong(const std::vector<std::size_t>& closures, const std::vector<double>& chi2,
                               const Contradicted<Dim>& contradicted, const Gates& gates) {
  const double expected = contradicted.expected_by_chance(gates.confidence);
  const auto so_near = [&](std::size_t c) {
    return expected * std::pow(chi2[closures[c]] / gates.widest.closures, 0.5 * kPoseDof<Dim>);
  };
  const double least = 1.0 - gates.confidence;
  std::size_t count = closures.size();
  while (count > 0 && so_near(count - 1) > least * static_cast<double>(count)) --count;
  std::vector<double> fitting(count);
  for (std::size_t c = 0; c < count; ++c) fitting[c] = contradicted.count_sampled(closures[c]);
  const double all_fitting = std::accumulate(fitting.begin(), fitting.end(), 0.0);
  std::vector<bool> are_hardly_wrong(closures.size());
  for (std::size_t c = 0; c < count; ++c) are_hardly_wrong[c] = so_near(c) * fitting[c] <= least * all_fitting;
  return are_hardly_wrong;
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
  const Contradicted<Dim> contradicted(judgement, closures, widest);
  std::vector<bool> fits(closures.size());
  std::vector<std::size_t> open;  // between the gates, and not kept
  std::size_t right = 0;          // number between the gates that are taken as right
  for (std::size_t k = 0; k < closures.size(); ++k) {
    const bool is_kept = judgement.standing[k] == Standing::kKept;
    fits[k] = is_kept || chi2[k] < gates.narrow().closures;
    if (chi2[k] < gates.narrow().closures || chi2[k] >= widest) continue;
    if (is_kept || contradicted.count_fitting(k, 1) == 0) ++right;
    if (!is_kept) open.push_back(k);
  }
  if (open.empty()) return fits;
  std::ranges::stable_sort(open, {}, [&](std::size_t k) { return chi2[k]; });
  const std::vector<bool> are_hardly_wrong = hardly_wrong(open, chi2, contradicted, gates);
  const std::size_t most = std::max<std::size_t>(1, right);
  for (std::size_t c = 0; c < open.size(); ++c) {
    fits[open[c]] = are_hardly_wrong[c] || contradicted.count_fitting(open[c], most) < most;
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
