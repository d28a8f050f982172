// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <mapjoin/join/robust/closure_judgement.hpp>
#include <mapjoin/join/robust/predictions.hpp>
#include <mapjoin/model/linearise.hpp>

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

  /// The number of contradicted measurements that would pass the gate in the place of a closure; at most `most`.
  std::size_t count_fitting(std::size_t place, std::size_t most) const { return count_fitting(place, all_, most); }
  /// The same among those of a sample, without the closure's own.
  double count_sampled(std::size_t place) const { return static_cast<double>(count_fitting(place, sample_, sample_.size())); }

  /// The number of wrong closures that pass the gate by chance, as far as can be expected by how many of a sample would pass in
  /// the places of others; one more is taken to, as there may be few of them.
  double expected_by_chance() const {
    double fitting = 1.0;
    for (const std::size_t place : sample_) fitting += count_sampled(place);
    const auto sampled = static_cast<double>(sample_.size());
    return static_cast<double>(all_.size()) * fitting / (1.0 + sampled * std::max(0.0, sampled - 1.0));
  }

 private:
  /// `most` if the covariance of the mismatch is singular, as then nobody knows.
  std::size_t count_fitting(std::size_t place, const std::vector<std::size_t>& measured, std::size_t most) const {
    const Eigen::LLT<PoseMatrix<Dim>> covariance(judgement_.mismatches[place].covariance);
    if (!measured.empty() && covariance.info() != Eigen::Success) return most;
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
  std::ranges::sort(open, {}, [&](std::size_t k) { return chi2[k]; });
  const double expected = contradicted.expected_by_chance();
  const std::size_t most = std::max<std::size_t>(1, right);
  double as_near = 0.0;  // number of open closures so near
  double fitting = 0.0;  // of contradicted measurements in the places of all of them
  for (const std::size_t k : open) {
    const double here = contradicted.count_sampled(k);
    fitting += here;
    as_near += 1.0;
    const double wrong = expected * std::pow(chi2[k] / widest, 0.5 * kPoseDof<Dim>);
    const double share = std::max(1.0 / as_near, here / std::max(1.0, fitting));
    fits[k] = wrong * share <= 1.0 - gates.confidence || contradicted.count_fitting(k, most) < most;
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
