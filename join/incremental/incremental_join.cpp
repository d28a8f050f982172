// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/align/placement.hpp>
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
AddedPart IncrementalJoin<Dim>::add(Part<Dim> new_part, const std::stop_token& stop) {
  AddedPart added;
  parts_.push_back(std::move(new_part));
  const Part<Dim>& part = parts_.back();
  const double chi2_before = estimate_.chi2();
  const std::int64_t dof_before = estimate_.dof();
  const auto variables = asks_for_join(part) ? std::nullopt : enter(part);
  if (variables) {
    settle(*variables, added);
    added.is_joined = true;
    if (!added.converged || has_outgrown(chi2_before, dof_before)) join_anew(false, stop, added);
  } else {
    waiting_.push_back(parts_.size() - 1);
  }
  if (!waiting_.empty()) admit_waiting(stop, added);
  return added;
}

template <int Dim>
AddedPart IncrementalJoin<Dim>::add_all(std::vector<Part<Dim>> parts, const std::stop_token& stop) {
  AddedPart added;
  const std::size_t before = parts_.size();
  for (Part<Dim>& part : parts) {
    waiting_.push_back(parts_.size());
    parts_.push_back(std::move(part));
  }
  if (parts_.size() > before) join_anew(true, stop, added);
  if (waiting_.empty() || stop.stop_requested()) return added;
  // They do not hang together: as far as they do.
  std::vector<Part<Dim>> again(std::make_move_iterator(parts_.begin() + static_cast<std::ptrdiff_t>(before)),
                               std::make_move_iterator(parts_.end()));
  parts_.resize(before);
  std::erase_if(waiting_, [&](std::size_t k) { return k >= before; });
  for (Part<Dim>& part : again) added = add(std::move(part), stop);
  return added;
}

template <int Dim>
void IncrementalJoin<Dim>::settle(std::span<const Index> last, AddedPart& added) {
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
bool IncrementalJoin<Dim>::asks_for_join(const Part<Dim>& part) const {
  if (estimate_.variables().empty() || (speaks_of_world(part) && !is_held_by_world_)) return true;
  return std::any_of(part.fixed.begin(), part.fixed.end(), [&](const FixedPose<Dim>& fixed) { return pose(fixed.pose); });
}

/// Where the piece may stand in the frame of the estimate.
template <int Dim>
std::vector<Pose<Dim>> IncrementalJoin<Dim>::placements(const Part<Dim>& part, const Piece<Dim>& piece) const {
  if (piece.poses.empty()) return {Pose<Dim>{}};
  Ties<Dim> ties;
  for (const Index p : piece.poses) {
    if (const auto* known = pose(p)) ties.add_pose(*known, pose_in(piece, p));
  }
  for (const auto& o : part.pose_observations) {
    const Pose<Dim>* base = o.base == kWorld ? nullptr : pose(o.base);
    const Pose<Dim>* target = pose(o.target);
    const Pose<Dim>* own_base = find_pose(piece, o.base);  // never the World, which is no pose
    const Pose<Dim>* own_target = find_pose(piece, o.target);
    if (base && own_target) ties.add_pose(compose(*base, o.measured), *own_target);
    if (target && own_base) ties.add_pose(*target, compose(*own_base, o.measured));
  }
  for (const Index f : piece.features) {
    if (const auto* known = feature(f)) ties.add_point(*known, feature_in(piece, f));
  }
  return ties.candidates();
}

/// Whether what the part observes is in the estimate or in the part's own piece.
template <int Dim>
bool IncrementalJoin<Dim>::knows_ends(const Part<Dim>& part, const Piece<Dim>& piece) const {
  const auto knows_pose = [&](Index p) { return p == kWorld || pose(p) || holds(piece.poses, p); };
  const auto knows_feature = [&](Index f) { return feature(f) || holds(piece.features, f); };
  return std::all_of(part.pose_observations.begin(), part.pose_observations.end(),
                     [&](const auto& o) { return knows_pose(o.base) && knows_pose(o.target); }) &&
         std::all_of(part.feature_observations.begin(), part.feature_observations.end(),
                     [&](const auto& o) { return knows_pose(o.base) && knows_feature(o.target); });
}

template <int Dim>
Index IncrementalJoin<Dim>::enter_pose(Index index, const Pose<Dim>& value, bool is_held) {
  const Index v = estimate_.add_variable(true, index, value, is_held);
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
std::vector<MapFactor<Dim>> IncrementalJoin<Dim>::factors_of(const Part<Dim>& part) {
  std::vector<MapFactor<Dim>> factors;
  const auto add = [&](const LocalMap<Dim>& map) {
    std::vector<Index> variables{map.base == kWorld ? kWorld : poses_[map.base]};
    for (const Index p : map.poses) variables.push_back(poses_[p]);
    for (const Index f : map.features) variables.push_back(features_[f]);
    factors.emplace_back(map, std::move(variables));
  };
  if (part.map) add(*part.map);
  for (LocalMap<Dim>& single : observations_as_maps(part)) add(singles_.emplace_back(std::move(single)));
  return factors;
}

template <int Dim>
std::optional<std::vector<Index>> IncrementalJoin<Dim>::enter(const Part<Dim>& part) {
  const Piece<Dim> piece = composed(part);
  const auto candidates = placements(part, piece);
  if (candidates.empty() || !knows_ends(part, piece)) return std::nullopt;

  std::vector<Index> variables;
  std::vector<std::pair<Index, Pose<Dim>>> entered;  // with their place in the piece
  for (const Index p : piece.poses) {
    const auto fixed = std::find_if(part.fixed.begin(), part.fixed.end(), [&](const auto& f) { return f.pose == p; });
    if (poses_[p] < 0 && fixed != part.fixed.end()) enter_pose(p, fixed->value, true);
    if (poses_[p] < 0) entered.emplace_back(enter_pose(p, {}, false), pose_in(piece, p));
    variables.push_back(poses_[p]);
  }
  for (const Index f : piece.features) {
    if (features_[f] < 0) entered.emplace_back(enter_feature(f, Point<Dim>::Zero()), Pose<Dim>{feature_in(piece, f), {}});
    variables.push_back(features_[f]);
  }
  auto factors = factors_of(part);
  const auto place = [&](const Pose<Dim>& placement) {
    for (const auto& [v, in_piece] : entered) estimate_.place(v, compose(placement, in_piece));
  };
  place(cheapest_placement<Dim>(candidates, [&](const Pose<Dim>& placement) {
    place(placement);
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
    const Part<Dim>& part = parts_[k];
    for (const auto& o : part.pose_observations) {
      count_pose(o.base);
      count_pose(o.target);
    }
    for (const auto& o : part.feature_observations) count_feature(o.target);
    if (part.stretch) {
      count_pose(part.stretch->begin);
      count_pose(part.stretch->end);
    }
    if (part.map) std::for_each(part.map->features.begin(), part.map->features.end(), count_feature);
  }
  return shared;
}

/// Tries again what could not be tied, once more is known of it.
template <int Dim>
void IncrementalJoin<Dim>::admit_waiting(const std::stop_token& stop, AddedPart& added) {
  const std::size_t shared = shared_by_waiting();
  const bool is_news = waiting_.back() + 1 == parts_.size() && asks_for_join(parts_.back());
  if (shared <= shared_when_tried_ && !is_news) return;
  shared_when_tried_ = shared;
  join_anew(true, stop, added);
}

template <int Dim>
void IncrementalJoin<Dim>::join_anew(bool with_waiting, const std::stop_token& stop, AddedPart& added) {
  std::vector<const Part<Dim>*> parts;
  for (std::size_t k = 0; k < parts_.size(); ++k) {
    if (with_waiting || !std::binary_search(waiting_.begin(), waiting_.end(), k)) parts.push_back(&parts_[k]);
  }
  const MapSet<Dim> set = set_of(parts);
  const Network<Dim> network = network_of_parts(set);
  JoinOptions<Dim> options;
  options.origin = origin_;
  added.looked_anew = true;
  const auto joined = join(network, set.poses, set.features, options, stop);
  if (!joined) return;
  added.converged = joined->result.status == MinimiseStatus::kConverged;  // here, or at an estimate that is no better
  if (!with_waiting && !is_less_chi2(joined->result.chi2, estimate_.chi2())) return;
  take(parts, *joined, added);
  added.is_joined = added.joined_anew = true;
  if (!with_waiting) return;
  waiting_.clear();
  shared_when_tried_ = 0;
}

/// Starts over from a join of these parts.
template <int Dim>
void IncrementalJoin<Dim>::take(const std::vector<const Part<Dim>*>& parts, const Join<Dim>& joined, AddedPart& added) {
  const IncrementalEstimate<Dim> before = std::exchange(estimate_, {});
  poses_ = {};
  features_ = {};
  singles_.clear();
  is_held_by_world_ = false;
  std::vector<Index> held = joined.held;
  std::sort(held.begin(), held.end());
  for (const Part<Dim>* part : parts) {
    is_held_by_world_ = is_held_by_world_ || speaks_of_world(*part);
    const Piece<Dim> piece = composed(*part);
    for (const Index p : piece.poses) {
      const bool is_held = std::binary_search(held.begin(), held.end(), p);
      if (poses_[p] < 0) enter_pose(p, joined.state.pose(p), is_held);
    }
    for (const Index f : piece.features) {
      if (features_[f] < 0) enter_feature(f, joined.state.feature(f));
    }
    for (auto& factor : factors_of(*part)) estimate_.add_factor(std::move(factor));
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
