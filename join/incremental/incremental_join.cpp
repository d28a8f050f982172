// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <string>
#include <utility>

namespace mapjoin {

namespace {

/// The variable of a pose or feature, null where it has none.
template <typename Id>
const JoinedIndex* find_variable(const std::map<Id, JoinedIndex>& directory, const Id& id) {
  const auto found = directory.find(id);
  return found == directory.end() ? nullptr : &found->second;
}

}  // namespace

template <int Dim>
const Pose<Dim>* IncrementalJoin<Dim>::pose(const PoseId& id) const {
  const JoinedIndex* v = find_variable(names_->poses(), id);
  return v ? &estimate_.variable(*v).value : nullptr;
}

template <int Dim>
const Point<Dim>* IncrementalJoin<Dim>::feature(const FeatureId& id) const {
  const JoinedIndex* v = find_variable(names_->features(), id);
  return v ? &estimate_.variable(*v).value.translation : nullptr;
}

template <int Dim>
std::optional<PoseMatrix<Dim>> IncrementalJoin<Dim>::covariance(const PoseId& id) const {
  return snapshot()->covariance(id);
}

template <int Dim>
std::optional<PointMatrix<Dim>> IncrementalJoin<Dim>::covariance(const FeatureId& id) const {
  return snapshot()->covariance(id);
}

template <int Dim>
std::shared_ptr<const JoinedSnapshot<Dim>> IncrementalJoin<Dim>::snapshot() const {
  const std::lock_guard lock(published_->mutex);
  return published_->snapshot;
}

/// The former snapshot is let go outside the lock.
template <int Dim>
void IncrementalJoin<Dim>::publish() {
  auto next = std::make_shared<const JoinedSnapshot<Dim>>(names_, estimate_.kept());
  const std::lock_guard lock(published_->mutex);
  published_->snapshot.swap(next);
}

/// Null also for the World, which is no pose.
template <int Dim>
const Pose<Dim>* IncrementalJoin<Dim>::pose(const SubmapUpdate<Dim>& update, PoseIndex pose) const {
  return pose == kWorld ? nullptr : this->pose(update.poses[pose]);
}

template <int Dim>
const Point<Dim>* IncrementalJoin<Dim>::feature(const SubmapUpdate<Dim>& update, FeatureIndex feature) const {
  return this->feature(update.features[feature]);
}

template <int Dim>
Expected<void> IncrementalJoin<Dim>::accept(SubmapUpdate<Dim> update) {
  if (update.source.empty()) update.source = "update " + std::to_string(updates_.size() + 1);
  if (const auto checked = check_update(update); !checked) return checked;
  const Segment segment = update.segments.empty() ? Segment{0, -1} : update.segments.front();
  for (const PoseIndex p : indices(update.poses)) {
    const PoseId& id = update.poses[p];
    const auto known = driven_.find(id);
    const bool is_known = known != driven_.end();
    const auto wrong = [&](const char* what) { return bad_input(update.source + ": " + to_string(id) + what); };
    if (p < segment.begin || p > segment.end) {
      if (!is_known) return wrong(" is in no segment yet");
    } else if (is_known && p > segment.begin) {
      return wrong(" is in a segment already");
    } else if (is_known && !known->second) {
      return wrong(" is in a segment already, which does not end there or goes on in another one");
    }
  }
  for (PoseIndex p = segment.begin; p <= segment.end; ++p) driven_[update.poses[p]] = p == segment.end;
  updates_.push_back(std::move(update));
  return {};
}

template <int Dim>
Expected<AddedUpdate> IncrementalJoin<Dim>::add(SubmapUpdate<Dim> update, const std::stop_token& stop) {
  return accept(std::move(update)).map([&] {
    AddedUpdate added;
    join_last(stop, added);
    publish();
    return added;
  });
}

template <int Dim>
void IncrementalJoin<Dim>::join_last(const std::stop_token& stop, AddedUpdate& added) {
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
Expected<AddedUpdate> IncrementalJoin<Dim>::add_all(std::vector<SubmapUpdate<Dim>> updates, const std::stop_token& stop) {
  AddedUpdate added;
  const std::size_t before = updates_.size();
  for (SubmapUpdate<Dim>& update : updates) {
    if (const auto accepted = accept(std::move(update)); !accepted) return tl::unexpected(accepted.error());
    waiting_.push_back(updates_.size() - 1);
  }
  if (updates_.size() > before) adopt_batch(true, stop, added);
  if (!waiting_.empty() && !stop.stop_requested()) join_again_from(before, stop, added);
  publish();
  return added;
}

/// Those after the first `before` do not hang together: as far as they do.
template <int Dim>
void IncrementalJoin<Dim>::join_again_from(std::size_t before, const std::stop_token& stop, AddedUpdate& added) {
  std::vector<SubmapUpdate<Dim>> again(std::make_move_iterator(updates_.begin() + static_cast<std::ptrdiff_t>(before)),
                                       std::make_move_iterator(updates_.end()));
  updates_.resize(before);
  std::erase_if(waiting_, [&](std::size_t k) { return k >= before; });
  for (SubmapUpdate<Dim>& update : again) {
    updates_.push_back(std::move(update));
    join_last(stop, added);
  }
  added.is_joined = waiting_.empty() || waiting_.back() < before;
}

template <int Dim>
void IncrementalJoin<Dim>::settle(std::span<const JoinedIndex> last, AddedUpdate& added) {
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
  return std::ranges::any_of(update.graph.fixed, [&](const FixedPose<Dim>& fixed) { return pose(update, fixed.pose); });
}

/// Where the partial map may stand in the frame of the estimate.
template <int Dim>
std::vector<Pose<Dim>> IncrementalJoin<Dim>::alignments(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
  if (partial.poses.empty()) return {Pose<Dim>{}};
  Correspondences<Dim> correspondences;
  for (const PoseIndex p : partial.poses) {
    if (const auto* known = pose(update, p)) correspondences.add_pose(*known, pose_in(partial, p));
  }
  for (const auto& o : update.graph.pose_factors) {
    const Pose<Dim>* base = pose(update, o.base);
    const Pose<Dim>* target = pose(update, o.target);
    const Pose<Dim>* own_base = find_pose(partial, o.base);  // never the World, which is no pose
    const Pose<Dim>* own_target = find_pose(partial, o.target);
    if (base && own_target) correspondences.add_closure(o, compose(*base, o.measured), *own_target);
    if (target && own_base) correspondences.add_closure(o, *target, compose(*own_base, o.measured));
  }
  for (const FeatureIndex f : partial.features) {
    if (const auto* known = feature(update, f)) correspondences.add_point(*known, feature_in(partial, f));
  }
  return correspondences.candidates();
}

/// Whether what the update observes is in the estimate or in the update's own partial map.
template <int Dim>
bool IncrementalJoin<Dim>::knows_ends(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
  const auto knows_pose = [&](PoseIndex p) { return p == kWorld || pose(update, p) || holds(partial.poses, p); };
  const auto knows_feature = [&](FeatureIndex f) { return feature(update, f) || holds(partial.features, f); };
  return std::ranges::all_of(update.graph.pose_factors,
                             [&](const auto& o) { return knows_pose(o.base) && knows_pose(o.target); }) &&
         std::ranges::all_of(update.graph.feature_factors,
                             [&](const auto& o) { return knows_pose(o.base) && knows_feature(o.target); });
}

template <int Dim>
JoinedIndex IncrementalJoin<Dim>::enter_pose(const PoseId& id, const Pose<Dim>& value, bool is_anchored) {
  const JoinedIndex v = estimate_.add_variable(true, value, is_anchored);
  names_->enter(id, v);
  return v;
}

template <int Dim>
JoinedIndex IncrementalJoin<Dim>::enter_feature(const FeatureId& id, const Point<Dim>& value) {
  const JoinedIndex v = estimate_.add_variable(false, {value, {}}, false);
  names_->enter(id, v);
  return v;
}

template <int Dim>
std::vector<MapFactor<Dim>> IncrementalJoin<Dim>::factors_of(const SubmapUpdate<Dim>& update) {
  std::vector<MapFactor<Dim>> factors;
  const auto add = [&](const LocalMap<Dim>& map) {
    const auto variable_of = [&](PoseIndex p) { return names_->poses().at(update.poses[p]); };
    std::vector<JoinedIndex> variables{map.base == kWorld ? kJoinedWorld : variable_of(map.base)};
    for (const PoseIndex p : map.poses) variables.push_back(variable_of(p));
    for (const FeatureIndex f : map.features) variables.push_back(names_->features().at(update.features[f]));
    factors.emplace_back(map, std::move(variables));
  };
  std::ranges::for_each(update.graph.submaps, add);
  for (const auto& o : update.graph.pose_factors) {
    add(singles_.emplace_back(LocalMap<Dim>{o.base, {o.target}, {}, {o.measured}, {}, o.information}));
  }
  for (const auto& o : update.graph.feature_factors) {
    add(singles_.emplace_back(LocalMap<Dim>{o.base, {}, {o.target}, {}, {o.measured}, o.information}));
  }
  return factors;
}

template <int Dim>
std::optional<std::vector<JoinedIndex>> IncrementalJoin<Dim>::enter(const SubmapUpdate<Dim>& update) {
  const PartialMap<Dim> partial = composed(update);
  const auto candidates = alignments(update, partial);
  if (candidates.empty() || !knows_ends(update, partial)) return std::nullopt;

  std::vector<JoinedIndex> variables;
  std::vector<std::pair<JoinedIndex, Pose<Dim>>> entered;  // with their place in the partial map
  for (const PoseIndex p : partial.poses) {
    const PoseId& id = update.poses[p];
    const auto fixed = std::ranges::find(update.graph.fixed, p, &FixedPose<Dim>::pose);
    if (!names_->poses().contains(id) && fixed != update.graph.fixed.end()) enter_pose(id, fixed->value, true);
    if (!names_->poses().contains(id)) entered.emplace_back(enter_pose(id, {}, false), pose_in(partial, p));
    variables.push_back(names_->poses().at(id));
  }
  for (const FeatureIndex f : partial.features) {
    const FeatureId& id = update.features[f];
    if (!names_->features().contains(id)) {
      entered.emplace_back(enter_feature(id, Point<Dim>::Zero()), Pose<Dim>{feature_in(partial, f), {}});
    }
    variables.push_back(names_->features().at(id));
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
  for (const std::size_t k : waiting_) {
    const SubmapUpdate<Dim>& update = updates_[k];
    shared += static_cast<std::size_t>(std::ranges::count_if(update.poses, [&](const PoseId& id) { return pose(id); }));
    shared +=
        static_cast<std::size_t>(std::ranges::count_if(update.features, [&](const FeatureId& id) { return feature(id); }));
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
  if (set.segments.empty()) return;
  const SubmapGraph<Dim> graph = submap_graph_of(set);
  JoinOptions<Dim> options;
  options.origin = origin_;
  added.batch_checked = true;
  const auto joined = join(graph, set.poses, set.features, options, stop);
  if (!joined) return;
  added.converged = joined->result.status == MinimiseStatus::kConverged;  // here, or at an estimate that is no better
  if (!with_waiting && !is_less_chi2(joined->result.chi2, estimate_.chi2())) return;
  take(updates, set, *joined, added);
  added.is_joined = added.batch_adopted = true;
  if (!with_waiting) return;
  waiting_.clear();
  shared_when_tried_ = 0;
}

/// Starts over from a join of these updates, which are the set.
template <int Dim>
void IncrementalJoin<Dim>::take(const std::vector<const SubmapUpdate<Dim>*>& updates, const SubmapSet<Dim>& set,
                                const Join<Dim>& joined, AddedUpdate& added) {
  const IncrementalEstimate<Dim> before = std::exchange(estimate_, {});
  const auto names_before = std::exchange(names_, std::make_shared<JoinedNames>());
  singles_.clear();
  Table<PoseIndex, bool> is_anchored(set.poses.size(), false);
  for (const PoseIndex p : joined.anchored) is_anchored[p] = true;
  const IndexOf pose_index(set.poses);
  const IndexOf feature_index(set.features);
  for (const SubmapUpdate<Dim>* update : updates) {
    for (const PoseId& id : update->poses) {
      const PoseIndex p = *pose_index(id);
      if (!names_->poses().contains(id)) enter_pose(id, joined.state.poses[p], is_anchored[p]);
    }
    for (const FeatureId& id : update->features) {
      if (!names_->features().contains(id)) enter_feature(id, joined.state.features[*feature_index(id)]);
    }
    for (auto& factor : factors_of(*update)) estimate_.add_factor(std::move(factor));
  }
  is_anchored_by_world_ = speaks_of_world(set);
  settle({}, added);
  for (const auto& [id, v] : names_before->poses()) {
    const PoseVector<Dim> step = local(before.variable(v).value, *pose(id));
    added.metres = std::max(added.metres, step.template head<Dim>().norm());
    added.radians = std::max(added.radians, step.template tail<kRotationDof<Dim>>().norm());
  }
  for (const auto& [id, v] : names_before->features()) {
    added.metres = std::max(added.metres, (before.variable(v).value.translation - *feature(id)).norm());
  }
}

template class IncrementalJoin<2>;
template class IncrementalJoin<3>;

}  // namespace mapjoin
