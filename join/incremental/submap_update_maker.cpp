// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/submap_update_maker.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Poses per map if nothing else is asked for.
constexpr double kPosesPerMap = 10.0;

/// The update that makes a pose known, or of the first one if the pose is known already.
template <int Dim>
SubmapUpdate<Dim>& update_of(const PoseId& pose, std::vector<SubmapUpdate<Dim>>& updates) {
  return *std::ranges::find_if(updates, [&](const auto& u) { return u.segments.empty() || pose <= last_pose(u); });
}

}  // namespace

template <int Dim>
SubmapUpdateMaker<Dim>::SubmapUpdateMaker(SplitOptions split, MinimiseOptions solver)
    : split_(split), solver_(std::move(solver)) {
  demand_valid(split_);
  demand_valid(solver_);
  if (split_.rule == SplitRule::kAuto) split_ = {SplitRule::kPoses, kPosesPerMap};
}

template <int Dim>
bool SubmapUpdateMaker<Dim>::is_past(const PoseId& pose) const {
  return !eliminated_in_.empty() && pose != last_ && (eliminated_in_.contains(pose) || pose < last_);
}

template <int Dim>
bool SubmapUpdateMaker<Dim>::add(const Log<Dim>& news) {
  demand_sound(check_invariants(news));
  std::set<PoseId> late;
  const auto name = [&](PoseIndex pose) {
    if (is_past(news.poses[pose])) late.insert(news.poses[pose]);
    return news.poses[pose];
  };
  for (const auto& o : news.edges()) {
    const PoseId base = name(o.base);
    const PoseId target = name(o.target);
    (is_past(base) || is_past(target) ? closures_ : edges_).push_back({base, target, o});
  }
  for (const auto& o : news.observations()) {
    const PoseId pose = name(o.base);
    (is_past(pose) ? late_observations_ : observations_).push_back({pose, news.features[o.target], o});
  }
  for (const auto& o : news.pose_priors()) pose_priors_.push_back({name(o.target), o});
  for (const auto& o : news.feature_priors()) feature_priors_.push_back({news.features[o.target], o});
  return keep(late);
}

template <int Dim>
bool SubmapUpdateMaker<Dim>::keep(const std::set<PoseId>& poses) {
  std::set<std::size_t> stale;
  for (const PoseId& pose : poses) {
    const auto known = eliminated_in_.find(pose);
    if (known == eliminated_in_.end()) return false;
    if (const auto update = std::exchange(known->second, std::nullopt)) stale.insert(*update);
  }
  return std::ranges::all_of(stale, [&](std::size_t update) { return remake(update); });
}

template <int Dim>
bool SubmapUpdateMaker<Dim>::remake(std::size_t update) {
  const Log<Dim>& log = segments_.at(update);
  Split split = split_along(log, {{0, PoseIndex(std::ssize(log.poses) - 1), true}});
  for (const PoseIndex p : indices(log.poses)) split.kept[p] = !eliminated_in_.at(log.poses[p]);
  const auto built = build_local_maps<Dim>(log, split, {solver_, nullptr});
  if (!built || built->maps.empty()) return false;
  remade_.push_back({update, submap_updates_of(log, split, built->maps).front()});
  return true;
}

template <int Dim>
Expected<typename SubmapUpdateMaker<Dim>::Window> SubmapUpdateMaker<Dim>::window(bool is_end) const {
  LogBuilder<Dim> builder("", {}, Numbers::kChecked);
  for (const Edge& e : edges_) builder.add(e.base, e.target, e.observation);
  for (const Observation& s : observations_) builder.add(s.pose, s.feature, s.observation);
  auto log = std::move(builder).finish(PoseOrder::kOfIds);
  if (!log) return tl::unexpected(log.error());
  Window window{*std::move(log), {}, 0};
  Table<PoseIndex, bool> elsewhere(window.log.poses.size(), false);  // of poses that something from elsewhere concerns
  const auto mention = [&](const PoseId& id) {
    if (const auto pose = find_ascending(window.log.poses, id)) elsewhere[PoseIndex(*pose)] = true;
  };
  for (const Edge& closure : closures_) {
    mention(closure.base);
    mention(closure.target);
  }
  for (const PosePrior& of : pose_priors_) mention(of.pose);
  window.split = split(window.log, split_, elsewhere);
  auto& segments = window.split.segments;
  window.open_begin = is_end ? indices(window.log.poses).last : segments.back().begin;
  if (!is_end) segments.pop_back();
  for (Segment& segment : segments) {
    if (observations_of(window.log, segment).empty()) make_raw(segment, window.split);
  }
  std::erase_if(window.log.graph.pose_factors,
                [&](const auto& o) { return segments.empty() || later_pose(o) > segments.back().end; });
  return window;
}

template <int Dim>
Expected<std::vector<SubmapUpdate<Dim>>> SubmapUpdateMaker<Dim>::take(bool is_end) {
  std::vector<SubmapUpdate<Dim>> updates;
  if (edges_.empty() && observations_.empty()) {
    const bool has_late =
        !closures_.empty() || !late_observations_.empty() || !pose_priors_.empty() || !feature_priors_.empty();
    if (is_end && has_late) hand_over(updates = {SubmapUpdate<Dim>{}}, is_end);
    taken_ += updates.size();
    return updates;
  }
  auto next = window(is_end);
  if (!next) return tl::unexpected(next.error());
  if (next->split.segments.empty()) return updates;
  const auto built = build_local_maps<Dim>(next->log, next->split, {solver_, nullptr});
  if (!built) return tl::unexpected(built.error());
  note_poses(*next);
  note_maps(*next);
  updates = submap_updates_of(next->log, next->split, built->maps);
  hand_over(updates, is_end);
  forget(*next);
  taken_ += updates.size();
  return updates;
}

template <int Dim>
void SubmapUpdateMaker<Dim>::note_poses(const Window& window) {
  for (std::size_t k = 0; k < window.split.segments.size(); ++k) {
    const Segment& segment = window.split.segments[k];
    for (PoseIndex p = segment.begin; p <= segment.end; ++p) {
      const auto update = window.split.kept[p] ? std::nullopt : std::optional(taken_ + k);
      if (eliminated_in_.emplace(window.log.poses[p], update).second) last_ = window.log.poses[p];
    }
  }
}

/// Notes the odometry and observations of the window's local maps, to make them anew from.
template <int Dim>
void SubmapUpdateMaker<Dim>::note_maps(const Window& window) {
  const Log<Dim>& log = window.log;
  for (std::size_t k = 0; k < window.split.segments.size(); ++k) {
    const Segment& segment = window.split.segments[k];
    if (!segment.is_map) continue;
    LogBuilder<Dim> builder("", {}, Numbers::kChecked);
    for (const auto& o : odometry_of(log, segment)) builder.add(log.poses[o.base], log.poses[o.target], o);
    for (const auto& o : observations_of(log, segment)) builder.add(log.poses[o.base], log.features[o.target], o);
    segments_.emplace(taken_ + k, std::move(builder).finish(PoseOrder::kOfIds).value());
  }
}

template <int Dim>
void SubmapUpdateMaker<Dim>::hand_over(std::vector<SubmapUpdate<Dim>>& updates, bool is_end) {
  hand_over_closures(updates);
  hand_over_late_observations(updates);
  hand_over_pose_priors(updates);
  hand_over_feature_priors(updates, is_end);
}

template <int Dim>
void SubmapUpdateMaker<Dim>::hand_over_closures(std::vector<SubmapUpdate<Dim>>& updates) {
  std::erase_if(closures_, [&](const Edge& closure) {
    if (!eliminated_in_.contains(closure.base) || !eliminated_in_.contains(closure.target)) return false;
    SubmapUpdate<Dim>& update = update_of(std::max(closure.base, closure.target), updates);
    PoseFactor<Dim>& o = update.graph.pose_factors.emplace_back(closure.observation);
    o.base = enter_name(update.poses, closure.base);
    o.target = enter_name(update.poses, closure.target);
    return true;
  });
}

template <int Dim>
void SubmapUpdateMaker<Dim>::hand_over_pose_priors(std::vector<SubmapUpdate<Dim>>& updates) {
  std::erase_if(pose_priors_, [&](const PosePrior& of) {
    if (!eliminated_in_.contains(of.pose)) return false;
    SubmapUpdate<Dim>& update = update_of(of.pose, updates);
    update.graph.pose_factors.emplace_back(of.prior).target = enter_name(update.poses, of.pose);
    return true;
  });
}

template <int Dim>
void SubmapUpdateMaker<Dim>::hand_over_late_observations(std::vector<SubmapUpdate<Dim>>& updates) {
  for (const Observation& late : std::exchange(late_observations_, {})) {
    SubmapUpdate<Dim>& update = updates.front();
    FeatureFactor<Dim>& o = update.graph.feature_factors.emplace_back(late.observation);
    o.base = enter_name(update.poses, late.pose);
    o.target = enter_name(update.features, late.feature);
  }
}

/// One of a feature that is known already waits for an update that sees it again.
template <int Dim>
void SubmapUpdateMaker<Dim>::hand_over_feature_priors(std::vector<SubmapUpdate<Dim>>& updates, bool is_end) {
  std::erase_if(feature_priors_, [&](const FeaturePrior& of) {
    auto update = std::ranges::find_if(updates, [&](const auto& u) { return std::ranges::count(u.features, of.feature) > 0; });
    if (update == updates.end() && !is_end) return false;
    if (update == updates.end()) --update;
    update->graph.feature_factors.emplace_back(of.prior).target = enter_name(update->features, of.feature);
    return true;
  });
}

template <int Dim>
void SubmapUpdateMaker<Dim>::forget(const Window& window) {
  const auto& poses = window.log.poses;
  const auto is_open = [&](const PoseId& pose) {
    return indices(poses).contains(window.open_begin) && pose >= poses[window.open_begin];
  };
  std::erase_if(observations_, [&](const Observation& seen) { return !is_open(seen.pose); });
  std::erase_if(edges_, [&](const Edge& edge) {
    if (is_open(edge.base) && is_open(edge.target)) return false;
    const auto& last = poses[window.split.segments.back().end];
    if (edge.base > last || edge.target > last) closures_.push_back(edge);
    return true;
  });
}

template class SubmapUpdateMaker<2>;
template class SubmapUpdateMaker<3>;

}  // namespace mapjoin
