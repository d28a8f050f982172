// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <map>
#include <mapjoin/join/align/leaf.hpp>
#include <mapjoin/join/incremental/submap_update.hpp>
#include <mapjoin/localmap/build.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <set>
#include <stdexcept>
#include <utility>

namespace mapjoin {
namespace {

/// The number of the segment with which a pose becomes known.
std::size_t segment_of(const std::vector<Segment>& segments, PoseIndex pose) {
  const auto segment = std::ranges::lower_bound(segments, pose, {}, &Segment::end);
  if (segment == segments.end()) throw std::invalid_argument("a factor is of a pose behind the last segment");
  return static_cast<std::size_t>(segment - segments.begin());
}

/// The number of the update that sees each feature first; the last one if none does.
template <int Dim>
Table<FeatureIndex, std::size_t> first_seen(const std::vector<SubmapUpdate<Dim>>& updates, std::size_t features) {
  Table<FeatureIndex, std::size_t> first(features, updates.size() - 1);
  for (std::size_t k = updates.size(); k-- > 0;) {
    for (const auto& map : updates[k].graph.submaps) {
      for (const FeatureIndex f : map.features) first[f] = k;
    }
    for (const auto& o : updates[k].graph.feature_factors) first[o.target] = k;
  }
  return first;
}

/// Numbers names in the order in which they come.
template <typename Index, typename Id>
class Numbering {
 public:
  Index operator()(const Id& id) {
    const auto [place, is_new] = numbers_.emplace(id, names_.size());
    if (is_new) names_.push_back(id);
    return place->second;
  }
  Table<Index, Id> take_names() { return std::move(names_); }

 private:
  std::map<Id, Index> numbers_;
  Table<Index, Id> names_;
};

/// The numbering of the poses and features of one set.
template <int Dim>
struct NewNames {
  Numbering<PoseIndex, PoseId> poses;
  Numbering<FeatureIndex, FeatureId> features;

  /// Renumbers a graph from indices among `old_poses` and `old_features`.
  void renumber(FactorGraph<Dim>& graph, const PoseIds& old_poses, const FeatureIds& old_features) {
    mapjoin::renumber(graph, EachKind{[&](PoseIndex p) { return poses(old_poses[p]); },
                                      [&](FeatureIndex f) { return features(old_features[f]); }});
  }
};

/// Renumbers an update from indices among `poses` and `features` to its own.
template <int Dim>
void name(const PoseIds& poses, const FeatureIds& features, SubmapUpdate<Dim>& update) {
  NewNames<Dim> names;
  Segment& segment = update.segments.front();  // a map's poses are the first that its graph concerns
  for (PoseIndex p = segment.begin; !segment.is_map && p <= segment.end; ++p) names.poses(poses[p]);
  names.renumber(update.graph, poses, features);
  const PoseIndex end(segment.is_map ? std::ssize(update.graph.submaps.front().poses) : segment.end - segment.begin);
  segment = {0, end, segment.is_map};
  update.poses = names.poses.take_names();
  update.features = names.features.take_names();
}

/// True if the update has one segment at most, and its local map, if the segment is one, keeps exactly its poses.
template <int Dim>
bool is_of_its_segment(const SubmapUpdate<Dim>& update) {
  if (update.segments.empty()) return update.graph.submaps.empty();
  if (update.segments.size() > 1) return false;
  const Segment& segment = update.segments.front();
  if (segment.begin < 0 || segment.end < segment.begin || !indices(update.poses).contains(segment.end)) return false;
  if (!segment.is_map) return update.graph.submaps.empty();
  return update.graph.submaps.size() == 1 && keeps_all_of(update.graph.submaps.front(), segment);
}

/// The updates with each segment after the one whose last pose it begins with, and those without a segment last.
template <int Dim>
std::vector<const SubmapUpdate<Dim>*> as_driven(const std::vector<const SubmapUpdate<Dim>*>& updates) {
  const auto stays = [](const SubmapUpdate<Dim>* update) { return first_pose(*update) == last_pose(*update); };
  std::map<PoseId, std::vector<const SubmapUpdate<Dim>*>> by_first;  // per pose, the one that drives on behind those that stay
  std::set<PoseId> lasts;
  for (const auto* update : updates) {
    if (update->segments.empty()) continue;
    auto& from_there = by_first[first_pose(*update)];
    from_there.push_back(update);
    std::stable_partition(from_there.begin(), from_there.end(), stays);
    if (!stays(update)) lasts.insert(last_pose(*update));
  }
  std::vector<const SubmapUpdate<Dim>*> driven;
  for (const auto* update : updates) {
    if (update->segments.empty() || lasts.contains(first_pose(*update))) continue;
    auto next = by_first.find(first_pose(*update));
    if (next->second.front() != update) continue;  // the first one has led here
    while (next != by_first.end()) {
      append(driven, next->second);
      next = stays(next->second.back()) ? by_first.end() : by_first.find(last_pose(*next->second.back()));
    }
  }
  std::copy_if(updates.begin(), updates.end(), std::back_inserter(driven),
               [](auto* update) { return update->segments.empty(); });
  return driven;
}

}  // namespace

template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>& log, const Split& split,
                                                 const std::vector<LocalMap<Dim>>& maps) {
  demand_sound(check_maps_of_split(log, split, maps));
  std::vector<SubmapUpdate<Dim>> updates;
  auto map = maps.begin();
  for (const Segment& segment : split.segments) {
    SubmapUpdate<Dim>& update = updates.emplace_back();
    update.segments = {segment};
    if (segment.is_map) {
      update.graph.submaps = {*map++};
      continue;
    }
    const auto odometry = odometry_of(log, segment);
    const auto observations = observations_of(log, segment);
    update.graph.pose_factors.assign(odometry.begin(), odometry.end());
    update.graph.feature_factors.assign(observations.begin(), observations.end());
  }
  const auto graph_at = [&](PoseIndex pose) -> auto& {
    return updates[segment_of(split.segments, pose)].graph;
  };
  for (const auto& o : log.closures()) graph_at(later_pose(o)).pose_factors.push_back(o);
  for (const auto& o : log.pose_priors()) graph_at(o.target).pose_factors.push_back(o);
  for (const auto& fixed : log.graph.fixed) graph_at(fixed.pose).fixed.push_back(fixed);
  const auto seen = first_seen(updates, log.features.size());
  for (const auto& o : log.feature_priors()) updates[seen[o.target]].graph.feature_factors.push_back(o);
  for (auto& update : updates) name(log.poses, log.features, update);
  return updates;
}

template <int Dim>
std::vector<SubmapUpdate<Dim>> submap_updates_of(const SubmapSet<Dim>& set) {
  demand_sound(check_content(set).and_then([&] { return check_segments(set); }));
  std::vector<SubmapUpdate<Dim>> updates;
  auto map = set.graph.submaps.begin();
  for (const Segment& segment : set.segments) {
    SubmapUpdate<Dim>& update = updates.emplace_back();
    update.segments = {segment};
    if (segment.is_map) update.graph.submaps = {*map++};
  }
  const auto graph_at = [&](PoseIndex pose) -> auto& {
    return updates[segment_of(set.segments, pose)].graph;
  };
  for (const auto& o : set.graph.pose_factors) graph_at(later_pose(o)).pose_factors.push_back(o);
  for (const auto& fixed : set.graph.fixed) graph_at(fixed.pose).fixed.push_back(fixed);
  for (const auto& o : set.graph.feature_factors) {
    if (o.base != kWorld) graph_at(o.base).feature_factors.push_back(o);
  }
  const auto seen = first_seen(updates, set.features.size());
  for (const auto& o : set.graph.feature_factors) {
    if (o.base == kWorld) updates[seen[o.target]].graph.feature_factors.push_back(o);
  }
  for (auto& update : updates) name(set.poses, set.features, update);
  return updates;
}

template <int Dim>
Expected<void> check_update(const SubmapUpdate<Dim>& update) {
  const auto wrong = [&](const std::string& what) { return bad_input_of(update.source, what); };
  if (const auto checked = check_content(update); !checked) return checked;
  if (!is_of_its_segment(update)) return wrong("its local map is not of the poses of its one segment, in their order");
  if (has_levers(update.graph)) return wrong("priors with levers cannot be joined map by map");
  if (count_losses(update.graph) > 0) return wrong("factors with a loss cannot be joined map by map");
  return {};
}

template <int Dim>
PartialMap<Dim> composed(const SubmapUpdate<Dim>& update) {
  if (update.segments.empty()) return {};
  const Segment& segment = update.segments.front();
  const auto is_inside = [&](PoseIndex pose) { return pose >= segment.begin && pose <= segment.end; };
  SubmapGraph<Dim> alone;
  alone.segments = update.segments;
  for (const auto& map : update.graph.submaps) alone.maps.push_back({map, {}, {}, {}, {}});
  for (const auto& o : update.graph.pose_factors) {
    if (is_inside(o.base) && is_inside(o.target)) alone.factors.pose_factors.push_back(&o);
  }
  for (const auto& o : update.graph.feature_factors) {
    if (is_inside(o.base)) alone.factors.feature_factors.push_back(&o);
  }
  PartialMap<Dim> partial = Leaves<Dim>(alone).partial(0);
  partial.factors = {};
  return partial;
}

template <int Dim>
bool speaks_of_world(const SubmapUpdate<Dim>& update) {
  const auto is_of_world = [](const auto& o) { return o.base == kWorld; };
  return !update.graph.fixed.empty() || std::ranges::any_of(update.graph.pose_factors, is_of_world) ||
         std::ranges::any_of(update.graph.feature_factors, is_of_world);
}

template <int Dim>
bool has_closures_only(const SubmapUpdate<Dim>& update) {
  return update.segments.empty() && update.features.empty() && !speaks_of_world(update);
}

template <int Dim>
SubmapUpdate<Dim> with_map(SubmapUpdate<Dim> update, const SubmapUpdate<Dim>& map) {
  update.segments.clear();
  update.graph.submaps.clear();
  SubmapUpdate<Dim> with_map = set_of<Dim>({&map, &update});
  with_map.source = std::move(update.source);
  return with_map;
}

template <int Dim>
SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>& updates) {
  SubmapSet<Dim> set;
  NewNames<Dim> names;
  const auto driven = as_driven(updates);
  for (const auto* update : driven) {
    for (Segment segment : update->segments) {
      const auto number = [&](PoseIndex p) { return names.poses(update->poses[p]); };
      const PoseIndex begin = number(segment.begin);
      for (PoseIndex p = segment.begin + 1; p <= segment.end; ++p) number(p);
      set.segments.push_back({begin, number(segment.end), segment.is_map});
    }
  }
  for (const auto* update : driven) {
    FactorGraph<Dim> graph = update->graph;
    names.renumber(graph, update->poses, update->features);
    append(set.graph.submaps, graph.submaps);
    append(set.graph.pose_factors, graph.pose_factors);
    append(set.graph.feature_factors, graph.feature_factors);
    append(set.graph.fixed, graph.fixed);
  }
  set.poses = names.poses.take_names();
  set.features = names.features.take_names();
  return set;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                               \
  template std::vector<SubmapUpdate<Dim>> submap_updates_of(const Log<Dim>&, const Split&, const std::vector<LocalMap<Dim>>&); \
  template std::vector<SubmapUpdate<Dim>> submap_updates_of(const SubmapSet<Dim>&);                                            \
  template Expected<void> check_update(const SubmapUpdate<Dim>&);                                                              \
  template PartialMap<Dim> composed(const SubmapUpdate<Dim>&);                                                                 \
  template bool speaks_of_world(const SubmapUpdate<Dim>&);                                                                     \
  template bool has_closures_only(const SubmapUpdate<Dim>&);                                                                   \
  template SubmapUpdate<Dim> with_map(SubmapUpdate<Dim>, const SubmapUpdate<Dim>&);                                            \
  template SubmapSet<Dim> set_of(const std::vector<const SubmapUpdate<Dim>*>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
