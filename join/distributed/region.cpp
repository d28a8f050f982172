// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/dealer.hpp>
#include <mapjoin/distributed/partition.hpp>
#include <mapjoin/distributed/region.hpp>
#include <mapjoin/join/align/partial_map.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

template <typename Index>
Table<Index, Index> distinct(std::vector<Index> list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
  list.shrink_to_fit();
  return Table<Index, Index>(std::move(list));
}

/// The poses and features that factors mention.
template <int Dim>
void list_mentioned(const FactorGraph<Dim>& graph, Region<Dim>& region) {
  std::vector<PoseIndex> poses;
  std::vector<FeatureIndex> features;
  const auto add = [&](PoseIndex pose) {
    if (pose != kWorld) poses.push_back(pose);
  };
  for (const auto& o : graph.pose_factors) {
    add(o.base);
    add(o.target);
  }
  for (const auto& o : graph.feature_factors) {
    add(o.base);
    features.push_back(o.target);
  }
  region.poses = distinct(std::move(poses));
  region.features = distinct(std::move(features));
}

/// Packs the factors, whose poses and features are by the indices of all names.
template <int Dim>
void pack(FactorGraph<Dim>& graph, Region<Dim>& region) {
  const auto place = [&](PoseIndex pose) { return pose == kWorld ? kWorld : place_of(region.poses, pose); };
  for (auto& o : graph.pose_factors) {
    o.base = place(o.base);
    o.target = place(o.target);
    region.measured_rows += information_rank(o.information);
  }
  for (auto& o : graph.feature_factors) {
    o.base = place(o.base);
    o.target = place_of(region.features, o.target);
    region.measured_rows += information_rank(o.information);
  }
  region.factors = Writer().put(graph.pose_factors).put(graph.feature_factors).bytes();
}

/// Whether a region was told the value of what it mentions.
struct Known {
  Table<PoseIndex, bool> poses;
  Table<FeatureIndex, bool> features;
};

/// Values that come for some of what a region mentions, from several ranks: the first rank's count.
template <typename Index, typename Value>
void take(const std::vector<Index>& some, const std::vector<Value>& given, const Table<Index, Index>& listed,
          Table<Index, Value>& values, Table<Index, bool>& is_known) {
  for (std::size_t k = 0; k < some.size(); ++k) {
    const Index place = place_of(listed, some[k]);
    if (is_known[place]) continue;
    is_known[place] = true;
    values[place] = given[k];
  }
}

/// The region of which each rank dealt a part.
template <int Dim>
Region<Dim> received(std::vector<std::string> messages, Known& known) {
  FactorGraph<Dim> graph;
  std::vector<Dealt<Dim>> dealt;
  for (std::string& message : messages) {
    auto& d = dealt.emplace_back(decoded<Dim>(std::exchange(message, {})));
    graph.pose_factors.insert(graph.pose_factors.end(), d.pose_factors.begin(), d.pose_factors.end());
    graph.feature_factors.insert(graph.feature_factors.end(), d.feature_factors.begin(), d.feature_factors.end());
    release(d.pose_factors);
    release(d.feature_factors);
  }
  Region<Dim> region;
  list_mentioned(graph, region);
  region.start.poses.resize(region.poses.size());
  region.start.features.resize(region.features.size(), Point<Dim>::Zero());
  known.poses.resize(region.poses.size(), false);
  known.features.resize(region.features.size(), false);
  for (const auto& d : dealt) {
    take(d.poses, d.pose_values, region.poses, region.start.poses, known.poses);
    take(d.features, d.feature_values, region.features, region.start.features, known.features);
  }
  pack(graph, region);
  return region;
}

/// What is mentioned in several regions.
template <int Dim>
std::vector<Holding> shared_by(const Communicator& comm, const Regions<Dim>& regions) {
  std::vector<Holding> mentioned;
  for (std::size_t k = 0; k < regions.own.size(); ++k) {
    const auto number = static_cast<std::int32_t>(static_cast<std::size_t>(comm.rank()) * regions.per_rank + k);
    for (const PoseIndex p : regions.own[k].poses) mentioned.push_back({regions.numbering.number(p), number});
    for (const FeatureIndex f : regions.own[k].features) mentioned.push_back({regions.numbering.number(f), number});
  }
  return shared_holdings(comm, mentioned, regions.numbering.count());
}

/// What several regions mention takes the value that the first region that knows one has.
template <int Dim>
void make_equal(const Communicator& comm, Regions<Dim>& regions, std::vector<Known>& known) {
  const Numbering& n = regions.numbering;
  const auto first = static_cast<std::int32_t>(static_cast<std::size_t>(comm.rank()) * regions.per_rank);
  const auto is_own = [&](const Holding& held) {
    return held.holder >= first && held.holder < first + static_cast<std::int32_t>(regions.per_rank);
  };
  std::vector<Holding> held;
  for (const Holding& h : regions.shared) {
    if (!is_own(h)) continue;
    const auto k = static_cast<std::size_t>(h.holder - first);
    const Region<Dim>& region = regions.own[k];
    const bool is_known = n.is_pose(h.number) ? known[k].poses[place_of(region.poses, n.pose(h.number))]
                                              : known[k].features[place_of(region.features, n.feature(h.number))];
    if (is_known) held.push_back(h);
  }
  held = comm.gather(held);
  std::ranges::sort(held);
  Dealt<Dim> mine;
  for (std::size_t i = 0; i < held.size(); ++i) {
    const bool is_first = i == 0 || held[i - 1].number != held[i].number;
    if (!is_first || !is_own(held[i])) continue;
    const Region<Dim>& region = regions.own[static_cast<std::size_t>(held[i].holder - first)];
    if (n.is_pose(held[i].number)) {
      mine.poses.push_back(n.pose(held[i].number));
      mine.pose_values.push_back(region.start.poses[place_of(region.poses, mine.poses.back())]);
    } else {
      mine.features.push_back(n.feature(held[i].number));
      mine.feature_values.push_back(region.start.features[place_of(region.features, mine.features.back())]);
    }
  }
  const auto poses = comm.gather(mine.poses);
  const auto pose_values = comm.gather(mine.pose_values);
  const auto features = comm.gather(mine.features);
  const auto feature_values = comm.gather(mine.feature_values);
  for (std::size_t k = 0; k < regions.own.size(); ++k) {
    Region<Dim>& region = regions.own[k];
    for (std::size_t i = 0; i < poses.size(); ++i) {
      if (!holds(region.poses, poses[i])) continue;
      region.start.poses[place_of(region.poses, poses[i])] = pose_values[i];
      known[k].poses[place_of(region.poses, poses[i])] = true;
    }
    for (std::size_t i = 0; i < features.size(); ++i) {
      if (!holds(region.features, features[i])) continue;
      region.start.features[place_of(region.features, features[i])] = feature_values[i];
      known[k].features[place_of(region.features, features[i])] = true;
    }
  }
}

/// Holds the map: by fixed poses and priors, else by the first pose.
template <int Dim>
void anchor(const Communicator& comm, const LogPart<Dim>& whole, bool has_priors, std::vector<Region<Dim>>& regions) {
  std::vector<FixedPose<Dim>> fixed = whole.graph.fixed;
  std::ranges::sort(fixed, {}, &FixedPose<Dim>::pose);
  const bool is_held = comm.any(has_priors) || !fixed.empty();
  for (Region<Dim>& region : regions) {
    for (const auto& pose : fixed) {
      if (!holds(region.poses, pose.pose)) continue;
      region.anchored.push_back(place_of(region.poses, pose.pose));
      region.start.poses[region.anchored.back()] = pose.value;
    }
    if (!is_held && holds(region.poses, PoseIndex(0))) region.anchored = {0};
  }
}

template <int Dim>
bool has_priors(const FactorGraph<Dim>& apart) {
  const auto is_prior = [](const auto& o) { return o.base == kWorld; };
  return std::ranges::any_of(apart.pose_factors, is_prior) || !apart.feature_factors.empty();
}

}  // namespace

template <int Dim>
FactorGraph<Dim> factors_of(const Region<Dim>& region) {
  Reader reader(region.factors);
  FactorGraph<Dim> graph;
  graph.pose_factors = reader.take<PoseFactor<Dim>>();
  graph.feature_factors = reader.take<FeatureFactor<Dim>>();
  return graph;
}

template <int Dim>
Expected<Regions<Dim>> regions_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share, Values<Dim> start,
                                  std::size_t per_rank) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  Regions<Dim> regions{{whole.poses.size(), whole.features.size()}, per_rank, {}, {}};
  std::vector<Known> known(per_rank);
  {
    const Table<PoseIndex, std::size_t> cut = region_of_poses(comm, whole, share, ranks * per_rank);
    Dealer<Dim> dealer(cut, per_rank, share, start);
    for (std::size_t k = 0; k < per_rank; ++k) {
      regions.own.push_back(received<Dim>(comm.exchange(dealer.messages(k, ranks)), known[k]));
    }
  }
  const bool holds_priors = has_priors(share.apart);
  share = {};
  start = {};
  regions.shared = shared_by(comm, regions);
  make_equal(comm, regions, known);
  const auto knows_all = [](const Known& of) { return std::ranges::find(of.features, false) == of.features.end(); };
  if (comm.any(!std::ranges::all_of(known, knows_all))) {
    return bad_input(whole.source + ": a feature has a prior but is never observed");
  }
  anchor(comm, whole, holds_priors, regions.own);
  return regions;
}

#define MAPJOIN_INSTANTIATE(Dim)                            \
  template FactorGraph<Dim> factors_of(const Region<Dim>&); \
  template Expected<Regions<Dim>> regions_of(const Communicator&, const LogPart<Dim>&, LogShare<Dim>, Values<Dim>, std::size_t);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
