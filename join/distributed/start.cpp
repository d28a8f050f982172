// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/start.hpp>
#include <mapjoin/join/schedule.hpp>
#include <mapjoin/localmap/recover.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <optional>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// A share whose local maps are joined, each connected part in a frame of its own.
template <int Dim>
struct JoinedShare {
  Values<Dim> values;                             ///< Estimates of all poses and features of the share.
  Table<PoseIndex, std::size_t> part;             ///< The part of each pose.
  Table<FeatureIndex, std::size_t> feature_part;  ///< The part of each feature.
  std::size_t parts = 0;
  std::vector<const PoseFactor<Dim>*> pending;  ///< Closures between parts.
};

/// Assigns the poses and features that a map eliminated to the part of its base.
template <int Dim>
void note_interiors(const SubmapGraph<Dim>& graph, JoinedShare<Dim>& joined) {
  for (const Segment& segment : graph.segments) {
    for (PoseIndex p = segment.begin + 1; p < segment.end; ++p) {
      if (!graph.is_joined[p]) joined.part[p] = joined.part[segment.begin];
    }
  }
  for (const auto& map : graph.maps) {
    for (const FeatureIndex f : map.local_features) joined.feature_part[f] = joined.part[map.map.base];
  }
}

/// The joined share of partial maps, with what was eliminated recovered.
template <int Dim>
JoinedShare<Dim> recovered(const Log<Dim>& log, const Split& split, const SubmapGraph<Dim>& graph,
                           const JoinedPartialMaps<Dim>& partials, const MinimiseOptions& solver) {
  JoinedShare<Dim> joined;
  joined.values.poses.resize(log.poses.size());
  joined.values.features.resize(log.features.size(), Point<Dim>::Zero());
  joined.part.resize(log.poses.size(), 0);
  joined.feature_part.resize(log.features.size(), 0);
  joined.parts = partials.partials.size();
  joined.pending = partials.pending;
  for (std::size_t k = joined.parts; k-- > 0;) {  // the first part decides the values that parts have in common
    const PartialMap<Dim>& partial = partials.partials[k];
    write_values(partial.state, partial.poses, partial.features, joined.values);
    for (const PoseIndex p : partial.poses) joined.part[p] = k;
    for (const FeatureIndex f : partial.features) joined.feature_part[f] = k;
  }
  note_interiors(graph, joined);
  for (const auto& map : graph.maps) recover_local_features(map, joined.values);
  recover_interiors(log, split, graph.is_local, solver, joined.values);
  return joined;
}

/// Joins the local maps of a share.
template <int Dim>
JoinedShare<Dim> joined_share(const LogShare<Dim>& share, ShareMaps<Dim> built, const RunOptions& options) {
  const SubmapGraph<Dim> graph = submap_graph_of(share.log, built.split, std::move(built.maps), share.is_referenced_feature);
  const auto partials = join_segments(graph, {options.schedule, options.state, nullptr});
  return recovered(share.log, built.split, graph, partials, options.solver);
}

/// The factors by which the outlines of all shares are aligned.
template <int Dim>
GlobalFactors<Dim> global_factors(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                  const JoinedShare<Dim>& joined) {
  constexpr std::size_t kMost = SharedFactors<Dim>::kMost;
  std::vector<PoseFactor<Dim>> closures;
  std::vector<PoseFactor<Dim>> priors;
  for (const auto& o : share.apart.pose_factors) (o.base == kWorld ? priors : closures).push_back(o);
  for (const auto* o : joined.pending) {
    closures.push_back(*o);
    renumber(closures.back(), [&](auto place) { return index_in(share, place); });
  }
  return {comm.gather(evenly_chosen(closures, kMost)), comm.gather(evenly_chosen(priors, kMost)), whole.graph.fixed};
}

/// A pose of a part that no other part has, by its place in the share; any of its poses if there is none.
template <int Dim>
PoseIndex anchor_of(const LogShare<Dim>& share, const JoinedShare<Dim>& joined, std::size_t part) {
  std::optional<PoseIndex> any;
  for (const PoseIndex p : indices(share.poses)) {
    if (joined.part[p] != part) continue;
    if (!share.is_referenced[p]) return p;
    if (!any) any = p;
  }
  return any.value();
}

/// The observations of a part whose features other shares may have, too, by the indices of the share.
template <int Dim>
std::vector<FeatureFactor<Dim>> shared_observations(const LogShare<Dim>& share, const JoinedShare<Dim>& joined,
                                                    std::size_t part) {
  std::vector<FeatureFactor<Dim>> shared;
  for (const auto& o : share.log.observations()) {
    if (joined.part[o.base] == part && joined.feature_part[o.target] == part && share.is_referenced_feature[o.target]) {
      shared.push_back(o);
    }
  }
  return evenly_chosen(shared, SharedFactors<Dim>::kMost);
}

/// The poses of the outline of a part, by their indices among all names and in the share, ascending: those that `observations`
/// and the factors of all refer to, those where shares meet, and the anchor.
template <int Dim>
std::vector<std::pair<PoseIndex, PoseIndex>> outline_poses(const LogShare<Dim>& share, const JoinedShare<Dim>& joined,
                                                           std::size_t part,
                                                           const std::vector<FeatureFactor<Dim>>& observations,
                                                           const std::vector<PoseIndex>& referenced, PoseIndex anchor) {
  Table<PoseIndex, bool> is_in(share.poses.size(), false);
  for (const auto& o : observations) is_in[o.base] = true;
  is_in[anchor] = true;
  const auto [first, last] = std::ranges::minmax(share.poses);  // where shares meet: they are cut by index
  std::vector<std::pair<PoseIndex, PoseIndex>> poses;
  for (const PoseIndex p : indices(share.poses)) {
    const PoseIndex index = share.poses[p];
    const bool is_wanted = is_in[p] || index == first || index == last || std::ranges::binary_search(referenced, index);
    if (is_wanted && joined.part[p] == part) poses.emplace_back(index, p);
  }
  std::ranges::sort(poses);
  return poses;
}

template <int Dim>
Outline<Dim> outline_of(const LogShare<Dim>& share, const JoinedShare<Dim>& joined, const std::vector<PoseIndex>& referenced,
                        std::size_t part) {
  Outline<Dim> outline;
  outline.observations = shared_observations(share, joined, part);
  const PoseIndex anchor = anchor_of(share, joined, part);
  outline.anchor = share.poses[anchor];
  for (const auto& [index, p] : outline_poses(share, joined, part, outline.observations, referenced, anchor)) {
    outline.poses.push_back(index);
    outline.values.poses.push_back(joined.values.poses[p]);
  }
  for (const FeatureIndex f : indices(share.features)) {
    if (joined.feature_part[f] != part || !share.is_referenced_feature[f]) continue;
    outline.features.push_back(share.features[f]);
    outline.values.features.push_back(joined.values.features[f]);
  }
  for (auto& o : outline.observations) renumber(o, [&](auto place) { return index_in(share, place); });
  return outline;
}

}  // namespace

template <int Dim>
Values<Dim> start_of(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share, ShareMaps<Dim> maps,
                     const RunOptions& options) {
  JoinedShare<Dim> joined = joined_share(share, std::move(maps), options);
  const GlobalFactors<Dim> factors = global_factors(comm, whole, share, joined);
  const std::vector<PoseIndex> referenced = factors.poses();
  std::vector<Outline<Dim>> outlines;
  for (std::size_t k = 0; k < joined.parts; ++k) outlines.push_back(outline_of(share, joined, referenced, k));
  const std::vector<Pose<Dim>> frames = frames_of(comm, outlines, factors);
  Values<Dim> start = std::move(joined.values);
  for (const PoseIndex p : indices(share.poses)) start.poses[p] = compose(frames[joined.part[p]], start.poses[p]);
  for (const FeatureIndex f : indices(share.features)) {
    start.features[f] = transform(frames[joined.feature_part[f]], start.features[f]);
  }
  return start;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                \
  template Values<Dim> start_of(const Communicator&, const LogPart<Dim>&, const LogShare<Dim>&, ShareMaps<Dim>, \
                                const RunOptions&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
