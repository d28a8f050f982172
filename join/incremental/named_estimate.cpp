// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/align/alignment.hpp>
#include <mapjoin/join/incremental/named_estimate.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The variable of a pose or feature; null if it has none.
template <typename Id>
const JoinedIndex* find_variable(const std::map<Id, JoinedIndex>& directory, const Id& id) {
  const auto found = directory.find(id);
  return found == directory.end() ? nullptr : &found->second;
}

/// The ties of waiting updates as edges of a graph. Its vertices are the updates, in their order, then the estimate with all
/// names that it has, then each other name.
template <int Dim>
class Ties {
 public:
  Ties(std::size_t waiting, const NamedEstimate<Dim>& estimate)
      : estimate_(estimate), vertex_of_estimate_(static_cast<Vertex>(waiting)), count_(vertex_of_estimate_ + 1) {}

  void add(Vertex update, const SubmapUpdate<Dim>& names) {
    for (const PoseId& id : names.poses) ties_.emplace_back(update, vertex_of(id, estimate_.pose(id) != nullptr, poses_));
    for (const FeatureId& id : names.features) {
      ties_.emplace_back(update, vertex_of(id, estimate_.feature(id) != nullptr, features_));
    }
  }
  Vertex vertex_of_estimate() const { return vertex_of_estimate_; }
  std::vector<std::uint32_t> components() const { return components_of(make_graph(count_, ties_)); }

 private:
  template <typename Id>
  Vertex vertex_of(const Id& id, bool is_joined, std::map<Id, Vertex>& others) {
    if (is_joined) return vertex_of_estimate_;
    const auto [other, is_new] = others.try_emplace(id, count_);
    if (is_new) ++count_;
    return other->second;
  }

  const NamedEstimate<Dim>& estimate_;
  Vertex vertex_of_estimate_;
  Vertex count_;
  std::map<PoseId, Vertex> poses_;
  std::map<FeatureId, Vertex> features_;
  std::vector<Edge> ties_;
};

}  // namespace

template <int Dim>
const Pose<Dim>* NamedEstimate<Dim>::pose(const PoseId& id) const {
  const JoinedIndex* v = find_variable(names_->poses(), id);
  return v ? &estimate_.variable(*v).value : nullptr;
}

template <int Dim>
const Point<Dim>* NamedEstimate<Dim>::feature(const FeatureId& id) const {
  const JoinedIndex* v = find_variable(names_->features(), id);
  return v ? &estimate_.variable(*v).value.translation : nullptr;
}

/// The poses at which the partial map may be in the frame of the estimate.
template <int Dim>
std::vector<Pose<Dim>> NamedEstimate<Dim>::alignments(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
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

/// True if all that the update observes is in the estimate, in the update's own partial map or, as a feature, seen from there.
template <int Dim>
bool NamedEstimate<Dim>::knows_ends(const SubmapUpdate<Dim>& update, const PartialMap<Dim>& partial) const {
  const auto knows_pose = [&](PoseIndex p) { return p == kWorld || pose(update, p) || holds(partial.poses, p); };
  const auto is_seen = [&](FeatureIndex f) {
    return std::ranges::any_of(update.graph.feature_factors, [&](const auto& o) { return o.base != kWorld && o.target == f; });
  };
  const auto knows_feature = [&](FeatureIndex f) { return feature(update, f) || holds(partial.features, f) || is_seen(f); };
  return std::ranges::all_of(update.graph.pose_factors,
                             [&](const auto& o) { return knows_pose(o.base) && knows_pose(o.target); }) &&
         std::ranges::all_of(update.graph.feature_factors,
                             [&](const auto& o) { return o.base == kWorld ? knows_feature(o.target) : knows_pose(o.base); });
}

template <int Dim>
JoinedIndex NamedEstimate<Dim>::enter_pose(const PoseId& id, const Pose<Dim>& value, bool is_anchored) {
  const JoinedIndex v = estimate_.add_variable(true, value, is_anchored);
  names_->enter(id, v);
  return v;
}

template <int Dim>
JoinedIndex NamedEstimate<Dim>::enter_feature(const FeatureId& id, const Point<Dim>& value) {
  const JoinedIndex v = estimate_.add_variable(false, {value, {}}, false);
  names_->enter(id, v);
  return v;
}

template <int Dim>
std::vector<MapFactor<Dim>> NamedEstimate<Dim>::factors_of(const SubmapUpdate<Dim>& update) {
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
std::optional<std::vector<JoinedIndex>> NamedEstimate<Dim>::enter(const SubmapUpdate<Dim>& update) {
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
  enter_late_features(update);
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
  add_factors(update, std::move(factors));
  return variables;
}

/// Enters features that poses of other updates see, where they do.
template <int Dim>
void NamedEstimate<Dim>::enter_late_features(const SubmapUpdate<Dim>& update) {
  for (const auto& o : update.graph.feature_factors) {
    const FeatureId& id = update.features[o.target];
    if (o.base != kWorld && !names_->features().contains(id)) enter_feature(id, transform(*pose(update, o.base), o.measured));
  }
}

template <int Dim>
void NamedEstimate<Dim>::add_factors(const SubmapUpdate<Dim>& update, std::vector<MapFactor<Dim>> factors) {
  for (auto& factor : factors) {
    factors_[&update].push_back(estimate_.add_factor(std::move(factor)));
  }
}

template <int Dim>
std::size_t NamedEstimate<Dim>::shared_with(const SubmapUpdate<Dim>& update) const {
  return static_cast<std::size_t>(std::ranges::count_if(update.poses, [&](const PoseId& id) { return pose(id); }) +
                                  std::ranges::count_if(update.features, [&](const FeatureId& id) { return feature(id); }));
}

template <int Dim>
void NamedEstimate<Dim>::leave(const SubmapUpdate<Dim>& update) {
  const auto entered = factors_.extract(&update);
  if (!entered) return;  // it has no factors
  for (const FactorIndex f : entered.mapped()) estimate_.remove_factor(f);
}

template <int Dim>
void NamedEstimate<Dim>::enter_at(const SubmapUpdate<Dim>& update, const JoinedSet<Dim>& joined) {
  for (const PoseId& id : update.poses) {
    const auto p = joined.pose_index(id);
    if (p && !names_->poses().contains(id)) enter_pose(id, joined.state.poses[*p], joined.is_anchored[*p]);
  }
  for (const FeatureId& id : update.features) {
    const auto f = joined.feature_index(id);
    if (f && !names_->features().contains(id)) enter_feature(id, joined.state.features[*f]);
  }
  add_factors(update, factors_of(update));
}

template <int Dim>
std::shared_ptr<const JoinedSnapshot<Dim>> NamedEstimate<Dim>::snapshot() {
  return std::make_shared<const JoinedSnapshot<Dim>>(names_, estimate_.kept());
}

template <int Dim>
StepSize NamedEstimate<Dim>::moved_from(const NamedEstimate& before) const {
  StepSize moved;
  for (const auto& [id, v] : before.names_->poses()) {
    const Pose<Dim>* now = pose(id);
    if (!now) continue;
    const PoseVector<Dim> step = local(before.estimate_.variable(v).value, *now);
    moved.metres = std::max(moved.metres, step.template head<Dim>().norm());
    moved.radians = std::max(moved.radians, step.template tail<kRotationDof<Dim>>().norm());
  }
  for (const auto& [id, v] : before.names_->features()) {
    const Point<Dim>* now = feature(id);
    if (now) moved.metres = std::max(moved.metres, (before.estimate_.variable(v).value.translation - *now).norm());
  }
  return moved;
}

template <int Dim>
std::vector<std::vector<std::size_t>> tied_updates(const std::deque<SubmapUpdate<Dim>>& updates,
                                                   const std::vector<std::size_t>& waiting,
                                                   const NamedEstimate<Dim>& estimate) {
  Ties<Dim> ties(waiting.size(), estimate);
  for (Vertex u = 0; u < waiting.size(); ++u) ties.add(u, updates[waiting[u]]);
  const std::vector<std::uint32_t> part = ties.components();
  std::map<std::uint32_t, std::vector<std::size_t>> groups;
  for (Vertex u = 0; u < waiting.size(); ++u) {
    if (estimate.is_empty() || part[u] == part[ties.vertex_of_estimate()]) groups[part[u]].push_back(waiting[u]);
  }
  std::vector<std::vector<std::size_t>> in_order;
  for (auto& [number, group] : groups) in_order.push_back(std::move(group));
  return in_order;
}

template class NamedEstimate<2>;
template class NamedEstimate<3>;
#define MAPJOIN_INSTANTIATE(Dim)                                                                    \
  template std::vector<std::vector<std::size_t>> tied_updates(const std::deque<SubmapUpdate<Dim>>&, \
                                                              const std::vector<std::size_t>&, const NamedEstimate<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
