// SPDX-License-Identifier: BSD-3-Clause
#include <fmt/format.h>

#include <algorithm>
#include <mapjoin/distributed/partition.hpp>
#include <mapjoin/distributed/region.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// What goes to one region: factors, and values of what they mention, by the indices of all names.
template <int Dim>
struct Dealt {
  std::vector<PoseFactor<Dim>> pose_factors;
  std::vector<FeatureFactor<Dim>> feature_factors;
  std::vector<PoseIndex> poses;
  std::vector<Pose<Dim>> pose_values;
  std::vector<FeatureIndex> features;
  std::vector<Point<Dim>> feature_values;
};

/// Deals out a share, in whose log poses and features are by its own indices.
template <int Dim>
class Dealer {
 public:
  /// `regions` are those of the poses of the share; there are `count` of them.
  Dealer(const Table<PoseIndex, std::size_t>& regions, const LogShare<Dim>& share, const Values<Dim>& values, std::size_t count)
      : regions_(regions),
        share_(share),
        values_(values),
        dealt_(count),
        given_(count, Table<PoseIndex, bool>(share.poses.size(), false)),
        given_features_(count, Table<FeatureIndex, bool>(share.features.size(), false)) {
    for (const PoseIndex p : indices(share.poses)) places_.emplace_back(share.poses[p], p);
    std::ranges::sort(places_);
  }

  std::vector<std::string> messages() {
    for (const auto& o : share_.log.edges()) deal(o, o.base, o.target);
    for (const auto& o : share_.log.observations()) deal(o);
    for (const auto& o : share_.apart.pose_factors) deal_apart(o);
    for (const auto& o : share_.apart.feature_factors) deal_apart(o);
    std::vector<std::string> messages;
    for (Dealt<Dim>& d : dealt_) {
      messages.push_back(Writer()
                             .put(d.pose_factors)
                             .put(d.feature_factors)
                             .put(d.poses)
                             .put(d.pose_values)
                             .put(d.features)
                             .put(d.feature_values)
                             .bytes());
      d = {};
    }
    return messages;
  }

 private:
  void deal(PoseFactor<Dim> o, PoseIndex base, PoseIndex target) {
    const std::size_t region = regions_[base];
    o.base = share_.poses[base];
    o.target = share_.poses[target];
    dealt_[region].pose_factors.push_back(o);
    give(base, region);
    give(target, region);
  }
  void deal(FeatureFactor<Dim> o) {
    const std::size_t region = regions_[o.base];
    give(o.base, region);
    give(o.target, region);
    o.base = share_.poses[o.base];
    o.target = share_.features[o.target];
    dealt_[region].feature_factors.push_back(o);
  }
  /// To the region of the end that is of this share.
  void deal_apart(const PoseFactor<Dim>& o) {
    const PoseIndex own = o.base == kWorld ? o.target : std::min(o.base, o.target);
    const PoseIndex place = std::ranges::lower_bound(places_, own, {}, &Place::first)->second;
    const std::size_t region = regions_[place];
    dealt_[region].pose_factors.push_back(o);
    give(place, region);
  }
  void deal_apart(const FeatureFactor<Dim>& prior) { dealt_.front().feature_factors.push_back(prior); }

  void give(PoseIndex p, std::size_t region) {
    if (given_[region][p]) return;
    given_[region][p] = true;
    dealt_[region].poses.push_back(share_.poses[p]);
    dealt_[region].pose_values.push_back(values_.poses[p]);
  }
  void give(FeatureIndex f, std::size_t region) {
    if (given_features_[region][f]) return;
    given_features_[region][f] = true;
    dealt_[region].features.push_back(share_.features[f]);
    dealt_[region].feature_values.push_back(values_.features[f]);
  }

  /// A pose by its index among all names, and its place in the share.
  using Place = std::pair<PoseIndex, PoseIndex>;

  const Table<PoseIndex, std::size_t>& regions_;
  const LogShare<Dim>& share_;
  const Values<Dim>& values_;
  std::vector<Dealt<Dim>> dealt_;
  std::vector<Place> places_;
  std::vector<Table<PoseIndex, bool>> given_;
  std::vector<Table<FeatureIndex, bool>> given_features_;
};

template <int Dim>
Dealt<Dim> decoded(const std::string& message) {
  Reader reader(message);
  Dealt<Dim> dealt;
  dealt.pose_factors = reader.take<PoseFactor<Dim>>();
  dealt.feature_factors = reader.take<FeatureFactor<Dim>>();
  dealt.poses = reader.take<PoseIndex>();
  dealt.pose_values = reader.take<Pose<Dim>>();
  dealt.features = reader.take<FeatureIndex>();
  dealt.feature_values = reader.take<Point<Dim>>();
  return dealt;
}

/// One of the lists of all, which are given up for it, in no more memory than it takes.
template <int Dim, typename Record>
std::vector<Record> joined(std::vector<Dealt<Dim>>& dealt, std::vector<Record> Dealt<Dim>::*list) {
  std::size_t size = 0;
  for (const auto& d : dealt) size += (d.*list).size();
  std::vector<Record> all;
  all.reserve(size);
  for (auto& d : dealt) {
    all.insert(all.end(), (d.*list).begin(), (d.*list).end());
    d.*list = {};
  }
  return all;
}

template <typename Index>
Table<Index, Index> distinct(std::vector<Index> list) {
  std::ranges::sort(list);
  list.erase(std::unique(list.begin(), list.end()), list.end());
  return Table<Index, Index>(std::move(list));
}

/// Values that came for some of the poses or features of a region, from several ranks: the first rank's count.
template <typename Index, typename Value>
class Received {
 public:
  Received(const Table<Index, Index>& listed, Value none) : listed_(listed), values_(listed.size(), none) {
    is_known_.resize(listed.size(), false);
  }
  void take(const std::vector<Index>& some, const std::vector<Value>& values) {
    for (std::size_t k = 0; k < some.size(); ++k) {
      if (!is_known(some[k])) set(some[k], values[k]);
    }
  }
  bool is_known(Index index) const { return is_known_[place_of(listed_, index)]; }
  const Value& operator[](Index index) const { return values_[place_of(listed_, index)]; }
  void set(Index index, const Value& value) {
    is_known_[place_of(listed_, index)] = true;
    values_[place_of(listed_, index)] = value;
  }
  const Table<Index, Value>& values() const { return values_; }
  bool knows_all() const { return std::ranges::find(is_known_, false) == is_known_.end(); }

 private:
  const Table<Index, Index>& listed_;
  Table<Index, Value> values_;
  Table<Index, bool> is_known_;
};

/// What several regions mention takes the value that the first rank that knows one has.
template <int Dim>
void make_equal(const Communicator& comm, const Region<Dim>& region, Received<PoseIndex, Pose<Dim>>& poses,
                Received<FeatureIndex, Point<Dim>>& features) {
  const Numbering& n = region.numbering;
  std::vector<Holding> known;
  for (const Holding& held : region.interface) {
    if (held.rank != comm.rank()) continue;
    if (n.is_pose(held.number) ? poses.is_known(n.pose(held.number)) : features.is_known(n.feature(held.number))) {
      known.push_back(held);
    }
  }
  known = comm.gather(known);
  std::ranges::sort(known);
  Dealt<Dim> mine;
  for (std::size_t k = 0; k < known.size(); ++k) {
    const bool is_first = k == 0 || known[k - 1].number != known[k].number;
    if (!is_first || known[k].rank != comm.rank()) continue;
    if (n.is_pose(known[k].number)) {
      mine.poses.push_back(n.pose(known[k].number));
      mine.pose_values.push_back(poses[mine.poses.back()]);
    } else {
      mine.features.push_back(n.feature(known[k].number));
      mine.feature_values.push_back(features[mine.features.back()]);
    }
  }
  const auto all_poses = comm.gather(mine.poses);
  const auto pose_values = comm.gather(mine.pose_values);
  for (std::size_t k = 0; k < all_poses.size(); ++k) {
    if (holds(region.partial.poses, all_poses[k])) poses.set(all_poses[k], pose_values[k]);
  }
  const auto all_features = comm.gather(mine.features);
  const auto feature_values = comm.gather(mine.feature_values);
  for (std::size_t k = 0; k < all_features.size(); ++k) {
    if (holds(region.partial.features, all_features[k])) features.set(all_features[k], feature_values[k]);
  }
}

/// The poses and features that the factors of a region mention.
template <int Dim>
void list_mentioned(Region<Dim>& region) {
  std::vector<PoseIndex> poses;
  std::vector<FeatureIndex> features;
  const auto add = [&](PoseIndex pose) {
    if (pose != kWorld) poses.push_back(pose);
  };
  for (const auto& o : region.graph.pose_factors) {
    add(o.base);
    add(o.target);
  }
  for (const auto& o : region.graph.feature_factors) {
    add(o.base);
    features.push_back(o.target);
  }
  region.partial.poses = distinct(std::move(poses));
  region.partial.features = distinct(std::move(features));
}

template <int Dim>
void select_factors(const Communicator& comm, Region<Dim>& region) {
  FactorSelection<Dim>& factors = region.partial.factors;
  FactorSelection<Dim>& priors = region.gauge.priors;
  for (const auto& o : region.graph.pose_factors) (o.base == kWorld ? priors : factors).pose_factors.push_back(&o);
  for (const auto& o : region.graph.feature_factors) (o.base == kWorld ? priors : factors).feature_factors.push_back(&o);
  for (const auto& fixed : region.graph.fixed) {
    if (holds(region.partial.poses, fixed.pose)) region.gauge.anchored.push_back(place_of(region.partial.poses, fixed.pose));
  }
  const bool is_held = comm.any(!priors.empty()) || !region.graph.fixed.empty();
  if (!is_held && holds(region.partial.poses, PoseIndex(0))) region.gauge.anchored = {0};
}

/// What is mentioned in several regions.
template <int Dim>
std::vector<Holding> interface_of(const Communicator& comm, const Region<Dim>& region) {
  std::vector<std::int32_t> mentioned;
  for (const PoseIndex p : region.partial.poses) mentioned.push_back(region.numbering.number(p));
  for (const FeatureIndex f : region.partial.features) mentioned.push_back(region.numbering.number(f));
  return shared_holdings(comm, mentioned, region.numbering.count());
}

template <int Dim>
std::vector<std::string> dealt_out(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                   const Values<Dim>& start) {
  const Table<PoseIndex, std::size_t> regions = regions_of(comm, whole, share);
  return Dealer<Dim>(regions, share, start, static_cast<std::size_t>(comm.size())).messages();
}

}  // namespace

template <int Dim>
Expected<std::unique_ptr<Region<Dim>>> region_of(const Communicator& comm, const LogPart<Dim>& whole, LogShare<Dim> share,
                                                 Values<Dim> start) {
  auto messages = dealt_out(comm, whole, share, start);
  share = {};
  start = {};
  messages = comm.exchange(std::move(messages));
  auto region = std::make_unique<Region<Dim>>();
  region->numbering = {whole.poses.size(), whole.features.size()};
  region->graph.fixed = whole.graph.fixed;
  std::vector<Dealt<Dim>> dealt;
  for (std::string& message : messages) dealt.push_back(decoded<Dim>(std::exchange(message, {})));
  region->graph.pose_factors = joined(dealt, &Dealt<Dim>::pose_factors);
  region->graph.feature_factors = joined(dealt, &Dealt<Dim>::feature_factors);
  list_mentioned(*region);
  region->interface = interface_of(comm, *region);
  Received<PoseIndex, Pose<Dim>> poses(region->partial.poses, Pose<Dim>{});
  Received<FeatureIndex, Point<Dim>> features(region->partial.features, Point<Dim>::Zero());
  for (const auto& d : dealt) {
    poses.take(d.poses, d.pose_values);
    features.take(d.features, d.feature_values);
  }
  make_equal(comm, *region, poses, features);
  if (comm.any(!features.knows_all())) return bad_input(whole.source + ": a feature has a prior but is never observed");
  region->partial.state = {poses.values(), features.values()};
  for (const auto& fixed : region->graph.fixed) {
    if (holds(region->partial.poses, fixed.pose)) {
      region->partial.state.poses[place_of(region->partial.poses, fixed.pose)] = fixed.value;
    }
  }
  select_factors(comm, *region);
  return region;
}

template Expected<std::unique_ptr<Region<2>>> region_of(const Communicator&, const LogPart<2>&, LogShare<2>, Values<2>);
template Expected<std::unique_ptr<Region<3>>> region_of(const Communicator&, const LogPart<3>&, LogShare<3>, Values<3>);

}  // namespace mapjoin::distributed
