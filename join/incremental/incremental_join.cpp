// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/incremental/incremental_join.hpp>
#include <mapjoin/join/tolerances.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/lists.hpp>
#include <stdexcept>
#include <string>
#include <utility>

namespace mapjoin {

template <int Dim>
IncrementalJoin<Dim>::IncrementalJoin(const Pose<Dim>& origin) : origin_(origin) {
  if (!is_valid(origin)) throw std::invalid_argument("the origin is not finite, or no rotation");
}

template <int Dim>
std::shared_ptr<const JoinedSnapshot<Dim>> IncrementalJoin<Dim>::snapshot() const {
  const std::lock_guard lock(published_->mutex);
  return published_->snapshot;
}

/// Releases the former snapshot outside the lock.
template <int Dim>
AddedUpdate IncrementalJoin<Dim>::published(AddedUpdate added) {
  added.chi2 = estimate_.chi2();
  added.dof = estimate_.dof();
  added.converged = is_converged_;
  auto next = estimate_.snapshot();
  const std::lock_guard lock(published_->mutex);
  published_->snapshot.swap(next);
  return added;
}

template <int Dim>
Expected<void> IncrementalJoin<Dim>::check(const SubmapUpdate<Dim>& update) const {
  return driven_.check(update);
}

template <int Dim>
Expected<void> IncrementalJoin<Dim>::check(std::span<const SubmapUpdate<Dim>> updates) const {
  DrivenSegments<Dim> driven = driven_;
  for (const SubmapUpdate<Dim>& update : updates) {
    if (const auto added = driven.add(update); !added) return added;
  }
  return {};
}

template <int Dim>
Expected<void> IncrementalJoin<Dim>::accept(SubmapUpdate<Dim> update) {
  if (update.source.empty()) update.source = "update " + std::to_string(updates_.size() + 1);
  return driven_.add(update).map([&] { updates_.push_back(std::move(update)); });
}

template <int Dim>
Expected<AddedUpdate> IncrementalJoin<Dim>::add(SubmapUpdate<Dim> update, const std::stop_token& stop) {
  return accept(std::move(update)).map([&] {
    AddedUpdate added;
    join_last(stop, added);
    added.is_joined = !is_waiting(updates_.size() - 1);
    return published(added);
  });
}

template <int Dim>
Expected<std::size_t> IncrementalJoin<Dim>::hold(SubmapUpdate<Dim> update) {
  if (!has_closures_only(update)) {
    return bad_input_of(update.source,
                        "only updates of closures, without a segment, features, priors and fixed poses, can be left out");
  }
  return accept(std::move(update)).map([&] {
    left_out_.insert(updates_.size() - 1);
    return updates_.size() - 1;
  });
}

template <int Dim>
AddedUpdate IncrementalJoin<Dim>::change(std::span<const std::size_t> out, std::span<const std::size_t> in,
                                         const std::stop_token& stop) {
  for (const auto& numbers : {out, in}) {
    for (const std::size_t k : numbers) {
      if (k < updates_.size() && has_closures_only(updates_[k])) continue;
      throw std::invalid_argument("update " + std::to_string(k) + " is not there, or not of closures alone");
    }
  }
  AddedUpdate changed;
  bool has_lost = false;
  for (const std::size_t k : out) {
    if (!left_out_.insert(k).second) continue;
    if (std::erase(waiting_, k) > 0) {
      shared_when_tried_ = 0;  // the others are to be tried by what they share
    } else {
      estimate_.leave(updates_[k]);
      has_lost = true;
    }
  }
  const double chi2_before = estimate_.chi2();
  const std::int64_t dof_before = estimate_.dof();
  for (const std::size_t k : in) {
    if (left_out_.erase(k) > 0 && (asks_for_join(updates_[k]) || !estimate_.enter(updates_[k]))) waiting_.push_back(k);
  }
  std::ranges::sort(waiting_);
  note(estimate_.settle({}), changed);
  if (has_lost || !is_converged_ || has_outgrown(chi2_before, dof_before)) join_all(stop, changed);
  if (!waiting_.empty()) admit_waiting(stop, changed);
  changed.is_joined = waiting_.empty();
  return published(changed);
}

template <int Dim>
Expected<AddedUpdate> IncrementalJoin<Dim>::keep_more(std::size_t number, const SubmapUpdate<Dim>& map,
                                                      const std::stop_token& stop) {
  SubmapUpdate<Dim>& update = updates_.at(number);
  return driven_.keep_more(update, map).map([&] {
    AddedUpdate changed;
    const bool is_joined = !is_waiting(number);
    if (is_joined) estimate_.leave(update);
    update = with_map(std::move(update), map);
    if (is_joined && !estimate_.enter(update)) waiting_.insert(std::ranges::lower_bound(waiting_, number), number);
    note(estimate_.settle({}), changed);
    if (!waiting_.empty()) admit_waiting(stop, changed);
    changed.is_joined = !is_waiting(number);
    return published(changed);
  });
}

template <int Dim>
AddedUpdate IncrementalJoin<Dim>::rejoin(const std::stop_token& stop) {
  AddedUpdate rejoined;
  note(estimate_.settle({}), rejoined);
  join_all(stop, rejoined);
  rejoined.is_joined = waiting_.empty();
  return published(rejoined);
}

template <int Dim>
void IncrementalJoin<Dim>::join_last(const std::stop_token& stop, AddedUpdate& added) {
  const SubmapUpdate<Dim>& update = updates_.back();
  const double chi2_before = estimate_.chi2();
  const std::int64_t dof_before = estimate_.dof();
  const auto variables = asks_for_join(update) ? std::nullopt : estimate_.enter(update);
  if (variables) {
    const auto deferred = estimate_.defer();
    if (deferred) note(*deferred, added);
    if (!deferred || has_outgrown(chi2_before, dof_before)) note(estimate_.settle(*variables), added);
    if (!is_converged_ || has_outgrown(chi2_before, dof_before)) join_all(stop, added);
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
  if (updates_.size() > before) adopt_first(tied_updates(updates_, waiting_, estimate_), stop, added);
  if (!waiting_.empty() && !added.batch_adopted && !stop.stop_requested()) join_again_from(before, stop, added);
  added.is_joined = waiting_.empty() || waiting_.back() < before;
  return published(added);
}

/// Joins the updates after the first `before` one by one, as they could not be joined at once.
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
}

template <int Dim>
void IncrementalJoin<Dim>::note(const Settling& settling, AddedUpdate& added) {
  added.metres = std::max(added.metres, settling.moved.metres);
  added.radians = std::max(added.radians, settling.moved.radians);
  added.eliminated += settling.eliminated;
  added.iterations += settling.iterations;
  is_converged_ = settling.converged;
}

/// True if the frame of the estimate cannot take the update, so that all must be joined again.
template <int Dim>
bool IncrementalJoin<Dim>::asks_for_join(const SubmapUpdate<Dim>& update) const {
  if (estimate_.is_empty() || (speaks_of_world(update) && !is_anchored_by_world_)) return true;
  return std::ranges::any_of(update.graph.fixed, [&](const FixedPose<Dim>& fixed) { return pose(update.poses[fixed.pose]); });
}

/// True if chi2 has grown by more than the added measurements can explain, relative to the fit so far.
template <int Dim>
bool IncrementalJoin<Dim>::has_outgrown(double chi2_before, std::int64_t dof_before) const {
  const double scale = dof_before > 0 ? std::max(1.0, chi2_before / static_cast<double>(dof_before)) : 1.0;
  const double growth = (estimate_.chi2() - chi2_before) / scale;
  const auto dof = static_cast<double>(std::max<std::int64_t>(1, estimate_.dof() - dof_before));
  const auto updates = static_cast<double>(updates_.size());
  return !(chi_squared_upper_tail(growth, dof) > std::min(kLeastGrowthProbability, 1.0 / (updates * updates)));
}

template <int Dim>
std::size_t IncrementalJoin<Dim>::shared_by_waiting() const {
  std::size_t shared = 0;
  for (const std::size_t k : waiting_) shared += estimate_.shared_with(updates_[k]);
  return shared;
}

/// Tries waiting updates again once they share more with the estimate.
template <int Dim>
void IncrementalJoin<Dim>::admit_waiting(const std::stop_token& stop, AddedUpdate& added) {
  const std::size_t shared = shared_by_waiting();
  const bool is_news = waiting_.back() + 1 == updates_.size() && asks_for_join(updates_.back());
  if (shared <= shared_when_tried_ && !is_news) return;
  shared_when_tried_ = shared;
  adopt_first(tied_updates(updates_, waiting_, estimate_), stop, added);
  if (stop.stop_requested()) shared_when_tried_ = 0;  // to be tried again
}

template <int Dim>
bool IncrementalJoin<Dim>::adopt_first(const std::vector<std::vector<std::size_t>>& groups, const std::stop_token& stop,
                                       AddedUpdate& added) {
  for (const std::vector<std::size_t>& group : groups) {
    if (adopt_batch(group, stop, added)) return true;
    if (stop.stop_requested()) return false;
  }
  return false;
}

template <int Dim>
void IncrementalJoin<Dim>::join_all(const std::stop_token& stop, AddedUpdate& added) {
  std::vector<std::size_t> joined;  // those that name something, and so are of a part
  for (std::size_t k = 0; k < updates_.size(); ++k) {
    const bool names_nothing = updates_[k].poses.empty() && updates_[k].features.empty();
    if (!names_nothing && !left_out_.contains(k) && !is_waiting(k)) joined.push_back(k);
  }
  const auto parts = tied_updates(updates_, joined, NamedEstimate<Dim>{});
  if (parts.size() <= 1) {
    adopt_batch({}, stop, added);
    return;
  }
  const std::vector<std::size_t> waiting = waiting_;
  append(waiting_, joined);
  std::ranges::sort(waiting_);
  if (!adopt_first(parts, stop, added)) waiting_ = waiting;
}

template <int Dim>
bool IncrementalJoin<Dim>::adopt_batch(const std::vector<std::size_t>& waiting, const std::stop_token& stop,
                                       AddedUpdate& added) {
  const auto is_asked_for = [&](std::size_t k) { return std::ranges::binary_search(waiting, k); };
  std::vector<const SubmapUpdate<Dim>*> updates;
  for (std::size_t k = 0; k < updates_.size(); ++k) {
    if (!left_out_.contains(k) && (!is_waiting(k) || is_asked_for(k))) updates.push_back(&updates_[k]);
  }
  const SubmapSet<Dim> set = set_of(updates);
  if (set.segments.empty()) return false;
  const SubmapGraph<Dim> graph = submap_graph_of(set);
  JoinOptions<Dim> options;
  options.origin = origin_;
  added.batch_checked = true;
  const auto joined = join(graph, set.poses, set.features, options, stop);
  if (!joined) return false;
  is_converged_ = joined->result.status == MinimiseStatus::kConverged;  // here, or at an estimate that is no better
  if (waiting.empty() && !is_less_chi2(joined->result.chi2, estimate_.chi2())) return false;
  take(updates, set, *joined, added);
  added.batch_adopted = true;
  if (waiting.empty()) return true;
  std::erase_if(waiting_, is_asked_for);
  shared_when_tried_ = shared_by_waiting();
  return true;
}

/// Starts over from a join of these updates, of which `set` is made.
template <int Dim>
void IncrementalJoin<Dim>::take(const std::vector<const SubmapUpdate<Dim>*>& updates, const SubmapSet<Dim>& set,
                                const Join<Dim>& joined, AddedUpdate& added) {
  const NamedEstimate<Dim> before = std::exchange(estimate_, {});
  const JoinedSet<Dim> all(set, joined);
  for (const SubmapUpdate<Dim>* update : updates) estimate_.enter_at(*update, all);
  is_anchored_by_world_ = speaks_of_world(set);
  note(estimate_.settle({}), added);
  const StepSize moved = estimate_.moved_from(before);
  added.metres = std::max(added.metres, moved.metres);
  added.radians = std::max(added.radians, moved.radians);
}

template class IncrementalJoin<2>;
template class IncrementalJoin<3>;

}  // namespace mapjoin
