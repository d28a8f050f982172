// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <algorithm>
#include <iterator>
#include <mapjoin/join/incremental/robust_incremental_join.hpp>
#include <mapjoin/localmap/taken_apart.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/linearise.hpp>
#include <set>
#include <string>
#include <utility>

namespace mapjoin {
namespace {

/// The ratio of updates to those when find_inliers() was asked last from which on it may be asked again.
constexpr double kGrowth = 1.25;

/// Names an update without a source by its number.
template <int Dim>
void name_by(std::size_t number, SubmapUpdate<Dim>& update) {
  if (update.source.empty()) update.source = "update " + std::to_string(number);
}

/// The closure of an update that has nothing else.
template <int Dim>
const PoseFactor<Dim>& closure_of(const SubmapUpdate<Dim>& update) {
  return update.graph.pose_factors.front();
}

/// The effect of two steps of the same addition together.
AddedUpdate both(const AddedUpdate& first, const AddedUpdate& second) {
  AddedUpdate both = second;
  both.metres = std::max(first.metres, second.metres);
  both.radians = std::max(first.radians, second.radians);
  both.eliminated += first.eliminated;
  both.iterations += first.iterations;
  both.batch_checked |= first.batch_checked;
  both.batch_adopted |= first.batch_adopted;
  return both;
}

/// True for each of `closures`, updates of one closure each, that find_inliers() keeps in a join with `updates`, with which
/// they are connected.
template <int Dim>
Expected<std::vector<bool>> kept_closures(const std::vector<const SubmapUpdate<Dim>*>& updates,
                                          const std::vector<const SubmapUpdate<Dim>*>& closures, const RobustOptions& options,
                                          const std::stop_token& stop) {
  auto all = updates;
  all.insert(all.end(), closures.begin(), closures.end());
  const SubmapSet<Dim> set = set_of(all);  // whose last pose factors are the closures
  return find_inliers(taken_apart(set).log, options, stop).map([&](const Inliers<Log<Dim>>& inliers) {
    const auto before = [](const PoseFactor<Dim>& a, const PoseFactor<Dim>& b) {
      return std::pair(a.base, a.target) < std::pair(b.base, b.target);
    };
    std::multiset<PoseFactor<Dim>, decltype(before)> kept(inliers.input.edges().begin(), inliers.input.edges().end(), before);
    std::vector<bool> is_kept;
    for (const auto& closure : std::span(set.graph.pose_factors).last(closures.size())) {
      const auto [first, last] = kept.equal_range(closure);
      const auto found = std::find(first, last, closure);
      is_kept.push_back(found != last);
      if (found != last) kept.erase(found);
    }
    return is_kept;
  });
}

}  // namespace

template <int Dim>
RobustIncrementalJoin<Dim>::RobustIncrementalJoin(const RobustOptions& options, const Pose<Dim>& origin)
    : options_(options), join_(origin) {
  demand_valid(options_);
  options_.odometry = false;
}

template <int Dim>
typename RobustIncrementalJoin<Dim>::Apart RobustIncrementalJoin<Dim>::apart(SubmapUpdate<Dim> update) {
  Apart apart;
  const Segment segment = driven_segment(update);
  std::set<PoseIndex> driven;  // poses that odometry has reached
  std::erase_if(update.graph.pose_factors, [&](const PoseFactor<Dim>& o) {
    if (o.base == kWorld) return false;
    const auto [before, after] = std::minmax(o.base, o.target);
    const bool is_step = before >= segment.begin && after <= segment.end && after == before + 1;
    if (is_step && !segment.is_map && driven.insert(after).second) return false;
    SubmapUpdate<Dim>& closure = apart.closures.emplace_back();
    closure.source = update.source;
    closure.poses = {update.poses[o.base], update.poses[o.target]};
    closure.graph.pose_factors = {{0, 1, o.measured, o.information, {}}};
    return true;
  });
  apart.update = set_of<Dim>({&update});  // without names that only closures concern
  apart.update.source = std::move(update.source);
  return apart;
}

template <int Dim>
bool RobustIncrementalJoin<Dim>::knows_ends(const SubmapUpdate<Dim>& closure) const {
  return join_.pose(closure.poses[0]) && join_.pose(closure.poses[1]);
}

/// False if the estimate leaves an end free to move. Uses (W⁻¹ + C)⁻¹ = (I + W C)⁻¹ W, as W may be singular.
template <int Dim>
bool RobustIncrementalJoin<Dim>::contradicts(const SubmapUpdate<Dim>& closure) const {
  constexpr int kDof = kPoseDof<Dim>;
  const PoseFactor<Dim>& o = closure_of(closure);
  const auto P = join_.snapshot()->covariance(closure.poses[0], closure.poses[1]);
  if (!P) return false;
  const auto linear = linearise<Dim>(o.measured, *join_.pose(closure.poses[0]), *join_.pose(closure.poses[1]));
  Eigen::Matrix<double, kDof, 2 * kDof> J;
  J << linear.J_base, linear.J_target;
  const PoseMatrix<Dim> I_WC = PoseMatrix<Dim>::Identity() + o.information * J * *P * J.transpose();
  const PoseVector<Dim> W_r = o.information * linear.residual;
  const double distance = linear.residual.dot(I_WC.partialPivLu().solve(W_r));
  return !(distance <= gate(static_cast<double>(information_rank(o.information))));
}

template <int Dim>
double RobustIncrementalJoin<Dim>::gate(double dof) const {
  return chi_squared_upper_quantile((1.0 - options_.confidence) / static_cast<double>(closures_.size()), dof);
}

template <int Dim>
Expected<std::vector<std::size_t>> RobustIncrementalJoin<Dim>::hold(std::vector<SubmapUpdate<Dim>> closures,
                                                                    const std::stop_token& stop, RobustlyAdded& done) {
  std::vector<std::size_t> held;
  for (SubmapUpdate<Dim>& closure : closures) {
    const std::size_t next = join_.update_count();
    if (knows_ends(closure)) {
      const auto number = join_.hold(std::move(closure));
      if (!number) return tl::unexpected(number.error());
      held.push_back(*number);
    } else {
      const auto added = join_.add(std::move(closure), stop);
      if (!added) return tl::unexpected(added.error());
      done.added = both(done.added, *added);
    }
    closures_.push_back(next);
  }
  return held;
}

template <int Dim>
Expected<RobustlyAdded> RobustIncrementalJoin<Dim>::add(SubmapUpdate<Dim> update, const std::stop_token& stop) {
  name_by(added_.size() + 1, update);
  if (const auto checked = join_.check(update); !checked) return tl::unexpected(checked.error());
  const auto before = join_.left_out();
  added_.push_back(join_.update_count());
  auto [rest, closures] = apart(std::move(update));
  RobustlyAdded done;
  done.added = join_.add(std::move(rest), stop).value();
  std::vector<std::size_t> fitting = hold(std::move(closures), stop, done).value();
  is_doubtful_ |= done.added.batch_checked;
  is_doubtful_ |= std::erase_if(fitting, [&](std::size_t k) { return contradicts(join_.update(k)); }) > 0;
  if (!fitting.empty()) try_closures(fitting, stop, done);
  if (is_due()) take_verdict(stop, done);
  done.added.is_joined = !join_.is_waiting(added_.back());
  compare_with(before, done);
  return done;
}

template <int Dim>
Expected<RobustlyAdded> RobustIncrementalJoin<Dim>::add_all(std::vector<SubmapUpdate<Dim>> updates,
                                                            const std::stop_token& stop) {
  const auto before = join_.left_out();
  std::vector<SubmapUpdate<Dim>> closures;
  for (std::size_t k = 0; k < updates.size(); ++k) name_by(added_.size() + 1 + k, updates[k]);
  if (const auto checked = join_.check(updates); !checked) return tl::unexpected(checked.error());
  for (SubmapUpdate<Dim>& update : updates) {
    added_.push_back(join_.update_count() + static_cast<std::size_t>(&update - updates.data()));
    Apart parts = apart(std::move(update));
    update = std::move(parts.update);
    std::ranges::move(parts.closures, std::back_inserter(closures));
  }
  RobustlyAdded done;
  done.added = join_.add_all(std::move(updates), stop).value();
  is_doubtful_ |= !hold(std::move(closures), stop, done).value().empty();  // held without a look at them
  if (!closures_.empty()) take_verdict(stop, done);
  done.added.is_joined = join_.waiting() == 0;
  compare_with(before, done);
  return done;
}

template <int Dim>
Expected<RobustlyAdded> RobustIncrementalJoin<Dim>::keep_more(std::size_t number, const SubmapUpdate<Dim>& map,
                                                              const std::stop_token& stop) {
  return join_.keep_more(added_.at(number), map, stop).map([&](const AddedUpdate& added) {
    is_doubtful_ |= added.batch_checked;
    return RobustlyAdded{.added = added};
  });
}

template <int Dim>
RobustlyAdded RobustIncrementalJoin<Dim>::judge(const std::stop_token& stop) {
  const auto before = join_.left_out();
  RobustlyAdded done;
  if (!closures_.empty()) take_verdict(stop, done);
  done.added = both(done.added, join_.rejoin(stop));
  compare_with(before, done);
  return done;
}

/// Judges by the growth of chi2 at the optimum, which the distances from a prediction tell only to first order.
template <int Dim>
void RobustIncrementalJoin<Dim>::try_closures(std::span<const std::size_t> closures, const std::stop_token& stop,
                                              RobustlyAdded& done) {
  const double chi2_before = join_.chi2();
  const std::int64_t dof_before = join_.dof();
  done.added = both(done.added, join_.change({}, closures, stop));
  if (join_.chi2() - chi2_before <= gate(static_cast<double>(join_.dof() - dof_before))) return;
  done.added = both(done.added, join_.change(closures, {}, stop));
  is_doubtful_ = true;
}

template <int Dim>
bool RobustIncrementalJoin<Dim>::is_due() const {
  return is_doubtful_ && !closures_.empty() &&
         static_cast<double>(join_.update_count()) >= kGrowth * static_cast<double>(asked_at_);
}

template <int Dim>
void RobustIncrementalJoin<Dim>::take_verdict(const std::stop_token& stop, RobustlyAdded& done) {
  done.is_judged = true;
  std::vector<const SubmapUpdate<Dim>*> believed;
  std::vector<const SubmapUpdate<Dim>*> doubtful;
  std::vector<std::size_t> numbers;  // of the doubtful
  for (std::size_t k = 0; k < join_.update_count(); ++k) {
    if (join_.is_waiting(k)) continue;
    const bool is_closure = std::ranges::binary_search(closures_, k);
    (is_closure ? doubtful : believed).push_back(&join_.update(k));
    if (is_closure) numbers.push_back(k);
  }
  const auto kept = kept_closures(believed, doubtful, options_, stop);
  if (kept || kept.error().kind != ErrorKind::kInterrupted) asked_at_ = join_.update_count();
  if (!kept) {
    done.no_verdict = kept.error();
    return;
  }
  is_doubtful_ = false;
  std::vector<std::size_t> out;
  std::vector<std::size_t> in;
  for (std::size_t c = 0; c < numbers.size(); ++c) {
    const bool is_out = join_.left_out().contains(numbers[c]);
    if ((*kept)[c] == is_out) (is_out ? in : out).push_back(numbers[c]);
  }
  if (!out.empty() || !in.empty()) done.added = both(done.added, join_.change(out, in, stop));
}

template <int Dim>
ClosureName RobustIncrementalJoin<Dim>::name(std::size_t closure) const {
  const SubmapUpdate<Dim>& update = join_.update(closure);
  return {update.poses[closure_of(update).base], update.poses[closure_of(update).target]};
}

template <int Dim>
void RobustIncrementalJoin<Dim>::compare_with(const std::set<std::size_t>& left_out_before, RobustlyAdded& done) const {
  const auto note = [&](const std::set<std::size_t>& here, const std::set<std::size_t>& there,
                        std::vector<ClosureName>& names) {
    std::vector<std::size_t> closures;
    std::ranges::set_difference(here, there, std::back_inserter(closures));
    for (const std::size_t k : closures) names.push_back(name(k));
  };
  note(join_.left_out(), left_out_before, done.rejected);
  note(left_out_before, join_.left_out(), done.readmitted);
}

template <int Dim>
std::vector<ClosureName> RobustIncrementalJoin<Dim>::left_out() const {
  std::vector<ClosureName> names;
  for (const std::size_t k : join_.left_out()) names.push_back(name(k));
  return names;
}

template class RobustIncrementalJoin<2>;
template class RobustIncrementalJoin<3>;

}  // namespace mapjoin
