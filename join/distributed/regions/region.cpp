// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/regions/dealer.hpp>
#include <mapjoin/distributed/regions/region.hpp>
#include <mapjoin/model/information.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/renumber.hpp>
#include <numeric>
#include <optional>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The poses and features that a graph refers to.
template <int Dim>
void list_referenced(const FactorGraph<Dim>& graph, Region<Dim>& region) {
  const auto add_pose = [&](PoseIndex pose) {
    if (pose != kWorld) region.poses.push_back(pose);
  };
  for (const auto& o : graph.pose_factors) {
    add_pose(o.base);
    add_pose(o.target);
  }
  for (const auto& o : graph.feature_factors) {
    add_pose(o.base);
    region.features.push_back(o.target);
  }
  for (const auto& fixed : graph.fixed) add_pose(fixed.pose);
  make_distinct(region.poses);
  make_distinct(region.features);
  region.poses.shrink_to_fit();
  region.features.shrink_to_fit();
}

/// Packs the factors, given by the indices of all names, by places.
template <int Dim>
void pack(FactorGraph<Dim>& graph, Region<Dim>& region) {
  renumber(graph, [&](auto index) { return place_in(region, index); });
  for (const auto& o : graph.pose_factors) region.measured_rows += information_rank(o.information);
  for (const auto& o : graph.feature_factors) region.measured_rows += information_rank(o.information);
  region.factors = Writer().put(graph.pose_factors).put(graph.feature_factors).bytes();
}

/// Flags of the poses and features whose values a region was told.
template <int Dim>
struct Told {
  explicit Told(const Region<Dim>& region) : poses(region.poses.size(), false), features(region.features.size(), false) {}

  bool has_all_features() const { return std::ranges::find(features, false) == features.end(); }

  Table<PoseIndex, bool> poses;
  Table<FeatureIndex, bool> features;
};

/// Takes values of the poses and features of a region: all of them, or those that it was not told yet.
template <typename Index, typename Value>
void take(const std::vector<Index>& some, const std::vector<Value>& given, bool takes_all, const Table<Index, Index>& listed,
          Table<Index, Value>& values, Table<Index, bool>& is_told) {
  for (std::size_t k = 0; k < some.size(); ++k) {
    if (!holds(listed, some[k])) continue;
    const Index place = place_of(listed, some[k]);
    if (is_told[place] && !takes_all) continue;
    is_told[place] = true;
    values[place] = given[k];
  }
}
template <int Dim>
void take(const Dealt<Dim>& given, bool takes_all, Region<Dim>& region, Told<Dim>& told) {
  take(given.poses, given.pose_values, takes_all, region.poses, region.start.poses, told.poses);
  take(given.features, given.feature_values, takes_all, region.features, region.start.features, told.features);
}

/// Adds the region of which each rank dealt a part, and which has these fixed poses. If several give a value, the first rank's
/// counts.
template <int Dim>
void receive(std::vector<std::string> messages, const std::vector<FixedPose<Dim>>& fixed, std::vector<Region<Dim>>& regions,
             std::vector<Told<Dim>>& told) {
  FactorGraph<Dim> graph;
  graph.fixed = fixed;
  std::vector<Dealt<Dim>> dealt;
  for (std::string& message : messages) {
    auto& d = dealt.emplace_back(decoded<Dim>(std::exchange(message, {})));
    append(graph.pose_factors, d.pose_factors);
    append(graph.feature_factors, d.feature_factors);
    release(d.pose_factors);
    release(d.feature_factors);
  }
  Region<Dim>& region = regions.emplace_back();
  list_referenced(graph, region);
  region.start.poses.resize(region.poses.size());
  region.start.features.resize(region.features.size(), Point<Dim>::Zero());
  told.emplace_back(region);
  for (const auto& d : dealt) take(d, false, region, told.back());
  pack(graph, region);
}

/// The number of the first region of this rank.
template <int Dim>
std::int32_t first_region(const Communicator& comm, const Regions<Dim>& regions) {
  return comm.rank() * static_cast<std::int32_t>(regions.per_rank);
}

/// Holdings of the poses and features that several regions have.
template <int Dim>
std::vector<Holding> shared_by(const Communicator& comm, const Regions<Dim>& regions) {
  std::vector<Holding> holdings;
  std::int32_t number = first_region(comm, regions);
  for (const Region<Dim>& region : regions.own) {
    for (const PoseIndex p : region.poses) holdings.push_back({regions.numbering.number(p), number});
    for (const FeatureIndex f : region.features) holdings.push_back({regions.numbering.number(f), number});
    ++number;
  }
  return shared_holdings(comm, holdings, regions.numbering.count());
}

/// The region of this rank of a holding, by its number here; nullopt if it is another rank's.
template <int Dim>
std::optional<std::size_t> own_region(const Communicator& comm, const Regions<Dim>& regions, const Holding& holding) {
  const std::int32_t number = holding.holder - first_region(comm, regions);
  const bool is_own = number >= 0 && number < static_cast<std::int32_t>(regions.per_rank);
  return is_own ? std::optional(static_cast<std::size_t>(number)) : std::nullopt;
}

/// The first region that was told a value, for each pose and feature that several regions have.
template <int Dim>
std::vector<Holding> first_told(const Communicator& comm, const Regions<Dim>& regions, const std::vector<Told<Dim>>& told) {
  std::vector<Holding> holdings;
  for (const Holding& holding : regions.shared) {
    const auto k = own_region(comm, regions, holding);
    if (!k) continue;
    const bool is_told = std::visit(EachKind{[&](PoseIndex p) { return told[*k].poses[place_in(regions.own[*k], p)]; },
                                             [&](FeatureIndex f) { return told[*k].features[place_in(regions.own[*k], f)]; }},
                                    regions.numbering.index(holding.number));
    if (is_told) holdings.push_back(holding);
  }
  holdings = comm.gather(holdings);
  std::ranges::sort(holdings);
  const auto are_of_one = [](const Holding& a, const Holding& b) { return a.number == b.number; };
  holdings.erase(std::unique(holdings.begin(), holdings.end(), are_of_one), holdings.end());
  return holdings;
}

/// Gives each pose and feature that several regions have the value of the first region that was told one.
template <int Dim>
void make_equal(const Communicator& comm, Regions<Dim>& regions, std::vector<Told<Dim>>& told) {
  Dealt<Dim> values;
  for (const Holding& holding : first_told(comm, regions, told)) {
    const auto k = own_region(comm, regions, holding);
    if (!k) continue;
    const Region<Dim>& region = regions.own[*k];
    std::visit(EachKind{[&](PoseIndex p) {
                          values.poses.push_back(p);
                          values.pose_values.push_back(region.start.poses[place_in(region, p)]);
                        },
                        [&](FeatureIndex f) {
                          values.features.push_back(f);
                          values.feature_values.push_back(region.start.features[place_in(region, f)]);
                        }},
               regions.numbering.index(holding.number));
  }
  values.poses = comm.gather(values.poses);
  values.pose_values = comm.gather(values.pose_values);
  values.features = comm.gather(values.features);
  values.feature_values = comm.gather(values.feature_values);
  for (std::size_t k = 0; k < regions.own.size(); ++k) take(values, true, regions.own[k], told[k]);
}

/// Starts features that have a prior but are never observed, which no share knows, where that prior has them.
template <int Dim>
void start_at_priors(const Told<Dim>& told, Region<Dim>& region) {
  if (told.has_all_features()) return;
  for (const auto& o : factors_of(region).feature_factors) {
    if (!told.features[o.target]) region.start.features[o.target] = o.measured;
  }
}

/// Fixes the gauge: by fixed poses and priors, otherwise by the first pose.
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
PartialMap<Dim> partial_map_of(const Region<Dim>& region, const FactorGraph<Dim>& graph, Values<Dim> values) {
  PartialMap<Dim> partial{Table<PoseIndex, PoseIndex>(region.poses.size()),
                          Table<FeatureIndex, FeatureIndex>(region.features.size()),
                          std::move(values),
                          {}};
  std::iota(partial.poses.begin(), partial.poses.end(), PoseIndex(0));
  std::iota(partial.features.begin(), partial.features.end(), FeatureIndex(0));
  for (const auto& o : graph.pose_factors) partial.factors.pose_factors.push_back(&o);
  for (const auto& o : graph.feature_factors) partial.factors.feature_factors.push_back(&o);
  return partial;
}

template <int Dim>
Regions<Dim> regions_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share, Values<Dim> start,
                        std::size_t per_rank) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  Regions<Dim> regions{{whole.poses.size(), whole.features.size()}, per_rank, {}, {}};
  std::vector<Told<Dim>> told;
  {
    const Table<PoseIndex, std::int32_t> cut = region_of_poses(comm, whole, share, ranks * per_rank);
    Dealer<Dim> dealer(cut, per_rank, share, start);
    const std::vector<FixedPose<Dim>> none;
    for (std::size_t k = 0; k < per_rank; ++k) {
      const bool is_first = comm.is_root() && k == 0;  // has the fixed poses that no factor refers to
      receive(comm.exchange(dealer.messages(k, ranks)), is_first ? whole.graph.fixed : none, regions.own, told);
    }
  }
  const bool holds_priors = has_priors(share.apart);
  share = {};
  start = {};
  regions.shared = shared_by(comm, regions);
  make_equal(comm, regions, told);
  for (std::size_t k = 0; k < per_rank; ++k) start_at_priors(told[k], regions.own[k]);
  anchor(comm, whole, holds_priors, regions.own);
  return regions;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                     \
  template FactorGraph<Dim> factors_of(const Region<Dim>&);                                          \
  template PartialMap<Dim> partial_map_of(const Region<Dim>&, const FactorGraph<Dim>&, Values<Dim>); \
  template Regions<Dim> regions_of(const Communicator&, const LogPart<Dim>&, LogShare<Dim>, Values<Dim>, std::size_t);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
