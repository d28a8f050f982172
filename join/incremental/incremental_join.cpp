// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <utility>

namespace mapjoin {

template <int Dim>
const Pose<Dim>* IncrementalJoin<Dim>::pose(Index pose) const {
  const Index v = poses_[pose];
  return v < 0 ? nullptr : &estimate_.variables()[static_cast<std::size_t>(v)].value;
}

template <int Dim>
const Point<Dim>* IncrementalJoin<Dim>::feature(Index feature) const {
  const Index v = features_[feature];
  return v < 0 ? nullptr : &estimate_.variables()[static_cast<std::size_t>(v)].value.translation;
}

template <int Dim>
AddedUpdate IncrementalJoin<Dim>::add(SubmapUpdate<Dim> update, const std::stop_token& stop) {
  AddedUpdate added;
  add(std::move(update), stop, added);
  return added;
}

template <int Dim>
void IncrementalJoin<Dim>::add(SubmapUpdate<Dim> new_update, const std::stop_token& stop, AddedUpdate& added) {
  updates_.push_back(std::move(new_update));
  const SubmapUpdate<Dim>& update = updates_.back();
  const double chi2_before = estimate_.chi2();
  const std::int64_t dof_before = estimate_.dof();
  const auto variables = asks_for_join(update) ? std::nullopt : enter(update);
  if (variables) {
    settle(*variables, added);
    added.is_joined = true;
    if (!added.converged || has_outgrown(chi2_before, dof_before)) adopt_batch(false, stop, added);
  } else {
    waiting_.push_back(updates_.size() - 1);
  }
  if (!waiting_.empty()) admit_waiting(stop, added);
}

template <int Dim>
AddedUpdate IncrementalJoin<Dim>::add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop) {
  AddedUpdate added;
  const std::size_t before = updates_.size();
  for (SubmapUpdate<Dim>& update : updates) {
    waiting_.push_back(updates_.size());
    updates_.push_back(std::move(update));
  }
  if (updates_.size() > before) adopt_batch(true, stop, added);
  if (waiting_.empty() || stop.stop_requested()) return added;
  // They do not hang together: as far as they do.
  std::vector<SubmapUpdate<Dim>> again(std::make_move_iterator(updates_.begin() + static_cast<std::ptrdiff_t>(before)),
                                       std::make_move_iterator(updates_.end()));
  updates_.resize(before);
  std::erase_if(waiting_, [&](std::size_t k) { return k >= before; });
  for (SubmapUpdate<Dim>& update : again) add(std::move(update), stop, added);
  added.is_joined = waiting_.empty() || waiting_.back() < before;
  return added;
}

template <int Dim>
void IncrementalJoin<Dim>::settle(std::span<const Index> last, AddedUpdate& added) {
  const Settling settling = estimate_.settle(last);
  added.metres = std::max(added.metres, settling.moved.metres);
  added.radians = std::max(added.radians, settling.moved.radians);
  added.chi2 = estimate_.chi2();
  added.dof = estimate_.dof();
  added.eliminated += settling.eliminated;
  added.iterations += settling.iterations;
  added.converged = settling.converged;
}

/// What the frame of the estimate cannot take.
template <int Dim>
bool IncrementalJoin<Dim>::asks_for_join(const SubmapUpdate<Dim>& update) const {
  if (estimate_.variables().empty() || (speaks_of_world(update) && !is_anchored_by_world_)) return true;
  return std::any_of(update.fixed.begin(), update.fixed.end(), [&](const FixedPose<Dim>& fixed) { return pose(fixed.pose); });
}

/// Where the partial map may stand in the frame of the estimate.
template <int Dim>
std::vector<Pose<Dim>> IncrementalJoin<Dim>::alignments(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
  if (partial.poses.empty()) return {Pose<Dim>{}};
  Correspondences<Dim> correspondences;
  for (const Index p : partial.poses) {
    if (const auto* known = pose(p)) correspondences.add_pose(*known, pose_in(partial, p));
  }
  for (const auto& o : update.pose_factors) {
    const Pose<Dim>* base = o.base == kWorld ? nullptr : pose(o.base);
    const Pose<Dim>* target = pose(o.target);
    const Pose<Dim>* own_base = find_pose(partial, o.base);  // never the World, which is no pose
    const Pose<Dim>* own_target = find_pose(partial, o.target);
    if (base && own_target) correspondences.add_pose(compose(*base, o.measured), *own_target);
    if (target && own_base) correspondences.add_pose(*target, compose(*own_base, o.measured));
  }
  for (const Index f : partial.features) {
    if (const auto* known = feature(f)) correspondences.add_point(*known, feature_in(partial, f));
  }
  return correspondences.candidates();
}

/// Whether what the update observes is in the estimate or in the update's own partial map.
template <int Dim>
bool IncrementalJoin<Dim>::knows_ends(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
  const auto knows_pose = [&](Index p) { return p == kWorld || pose(p) || holds(partial.poses, p); };
  const auto knows_feature = [&](Index f) { return feature(f) || holds(partial.features, f); };
  return std::all_of(update.pose_factors.begin(), update.pose_factors.end(),
                     [&](const auto& o) { return knows_pose(o.base) && knows_pose(o.target); }) &&
         std::all_of(update.feature_factors.begin(), update.feature_factors.end(),
                     [&](const auto& o) { return knows_pose(o.base) && knows_feature(o.target); });
}

template <int Dim>
Index IncrementalJoin<Dim>::enter_pose(Index index, const Pose<Dim>& value, bool is_anchored) {
  const Index v = estimate_.add_variable(true, index, value, is_anchored);
  poses_.enter(index, v);
  return v;
}

template <int Dim>
Index IncrementalJoin<Dim>::enter_feature(Index index, const Point<Dim>& value) {
  const Index v = estimate_.add_variable(false, index, {value, {}}, false);
  features_.enter(index, v);
  return v;
}

template <int Dim>
std::vector<MapFactor<Dim>> IncrementalJoin<Dim>::factors_of(const SubmapUpdate<Dim>& update) {
  std::vector<MapFactor<Dim>> factors;
  const auto add = [&](const LocalMap<Dim>& map) {
    std::vector<Index> variables{map.base == kWorld ? kWorld : poses_[map.base]};
    for (const Index p : map.poses) variables.push_back(poses_[p]);
    for (const Index f : map.features) variables.push_back(features_[f]);
    factors.emplace_back(map, std::move(variables));
  };
  if (update.map) add(*update.map);
  for (LocalMap<Dim>& single : observations_as_maps(update)) add(singles_.emplace_back(std::move(single)));
  return factors;
}

template <int Dim>
std::optional<std::vector<Index>> IncrementalJoin<Dim>::enter(const SubmapUpdate<Dim>& update) {
  const PartialMap<Dim> partial = composed(update);
  const auto candidates = alignments(update, partial);
  if (candidates.empty() || !knows_ends(update, partial)) return std::nullopt;

  std::vector<Index> variables;
  std::vector<std::pair<Index, Pose<Dim>>> entered;  // with their place in the partial map
  for (const Index p : partial.poses) {
    const auto fixed = std::find_if(update.fixed.begin(), update.fixed.end(), [&](const auto& f) { return f.pose == p; });
    if (poses_[p] < 0 && fixed != update.fixed.end()) enter_pose(p, fixed->value, true);
    if (poses_[p] < 0) entered.emplace_back(enter_pose(p, {}, false), pose_in(partial, p));
    variables.push_back(poses_[p]);
  }
  for (const Index f : partial.features) {
    if (features_[f] < 0) entered.emplace_back(enter_feature(f, Point<Dim>::Zero()), Pose<Dim>{feature_in(partial, f), {}});
    variables.push_back(features_[f]);
  }
  auto factors = factors_of(update);
  const auto place = [&](const Pose<Dim>& alignment) {
    for (const auto& [v, in_partial] : entered) estimate_.place(v, compose(alignment, in_partial));
  };
  place(cheapest_alignment<Dim>(candidates, [&](const Pose<Dim>& alignment) {
    place(alignment);
    double chi2 = 0.0;
    for (const auto& factor : factors) chi2 += factor.chi2(estimate_.variables());
    return chi2;
  }));
  for (auto& factor : factors) estimate_.add_factor(std::move(factor));
  return variables;
}

/// Whether the chi2 has grown by more than what was added can explain, the fit so far being as it is.
template <int Dim>
bool IncrementalJoin<Dim>::has_outgrown(double chi2_before, std::int64_t dof_before) const {
  const double scale = dof_before > 0 ? std::max(1.0, chi2_before / static_cast<double>(dof_before)) : 1.0;
  const double growth = (estimate_.chi2() - chi2_before) / scale;
  const auto dof = static_cast<double>(std::max<std::int64_t>(1, estimate_.dof() - dof_before));
  return !(chi_squared_upper_tail(growth, dof) > kLeastGrowthProbability);
}

template <int Dim>
std::size_t IncrementalJoin<Dim>::shared_by_waiting() const {
  std::size_t shared = 0;
  const auto count_pose = [&](Index p) { shared += p != kWorld && pose(p) ? 1 : 0; };
  const auto count_feature = [&](Index f) { shared += feature(f) ? 1 : 0; };
  for (const std::size_t k : waiting_) {
    const SubmapUpdate<Dim>& update = updates_[k];
    for (const auto& o : update.pose_factors) {
      count_pose(o.base);
      count_pose(o.target);
    }
    for (const auto& o : update.feature_factors) count_feature(o.target);
    if (update.segment) {
      count_pose(update.segment->begin);
      count_pose(update.segment->end);
    }
    if (update.map) std::for_each(update.map->features.begin(), update.map->features.end(), count_feature);
  }
  return shared;
}

/// Tries again what could not be tied, once more is known of it.
template <int Dim>
void IncrementalJoin<Dim>::admit_waiting(const std::stop_token& stop, AddedUpdate& added) {
  const std::size_t shared = shared_by_waiting();
  const bool is_news = waiting_.back() + 1 == updates_.size() && asks_for_join(updates_.back());
  if (shared <= shared_when_tried_ && !is_news) return;
  shared_when_tried_ = shared;
  adopt_batch(true, stop, added);
}

template <int Dim>
void IncrementalJoin<Dim>::adopt_batch(bool with_waiting, const std::stop_token& stop, AddedUpdate& added) {
  std::vector<const SubmapUpdate<Dim>*> updates;
  for (std::size_t k = 0; k < updates_.size(); ++k) {
    if (with_waiting || !std::binary_search(waiting_.begin(), waiting_.end(), k)) updates.push_back(&updates_[k]);
  }
  const SubmapSet<Dim> set = set_of(updates);
  const SubmapGraph<Dim> graph = submap_graph_of_updates(set);
  JoinOptions<Dim> options;
  options.origin = origin_;
  added.batch_checked = true;
  const auto joined = join(graph, set.poses, set.features, options, stop);
  if (!joined) return;
  added.converged = joined->result.status == MinimiseStatus::kConverged;  // here, or at an estimate that is no better
  if (!with_waiting && !is_less_chi2(joined->result.chi2, estimate_.chi2())) return;
  take(updates, *joined, added);
  added.is_joined = added.batch_adopted = true;
  if (!with_waiting) return;
  waiting_.clear();
  shared_when_tried_ = 0;
}

/// Starts over from a join of these updates.
template <int Dim>
void IncrementalJoin<Dim>::take(const std::vector<const SubmapUpdate<Dim>*>& updates, const Join<Dim>& joined,
                                AddedUpdate& added) {
  const IncrementalEstimate<Dim> before = std::exchange(estimate_, {});
  poses_ = {};
  features_ = {};
  singles_.clear();
  is_anchored_by_world_ = false;
  std::vector<Index> anchored = joined.anchored;
  std::sort(anchored.begin(), anchored.end());
  for (const SubmapUpdate<Dim>* update : updates) {
    is_anchored_by_world_ = is_anchored_by_world_ || speaks_of_world(*update);
    const PartialMap<Dim> partial = composed(*update);
    for (const Index p : partial.poses) {
      const bool is_anchored = std::binary_search(anchored.begin(), anchored.end(), p);
      if (poses_[p] < 0) enter_pose(p, joined.state.pose(p), is_anchored);
    }
    for (const Index f : partial.features) {
      if (features_[f] < 0) enter_feature(f, joined.state.feature(f));
    }
    for (auto& factor : factors_of(*update)) estimate_.add_factor(std::move(factor));
  }
  settle({}, added);
  for (const JoinedVariable<Dim>& was : before.variables()) {
    const Directory& directory = was.is_pose ? poses_ : features_;
    const PoseVector<Dim> step = local(was.value, estimate_.variables()[static_cast<std::size_t>(directory[was.index])].value);
    added.metres = std::max(added.metres, step.template head<Dim>().norm());
    if (was.is_pose) added.radians = std::max(added.radians, step.template tail<kRotationDof<Dim>>().norm());
  }
}

template class IncrementalJoin<2>;
template class IncrementalJoin<3>;

}  // namespace mapjoin
