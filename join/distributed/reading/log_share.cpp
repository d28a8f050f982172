// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/mpi/holdings.hpp>
#include <mapjoin/distributed/reading/log_share.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/model/log_builder.hpp>
#include <utility>

namespace mapjoin::distributed {
namespace {

/// The poses of each rank.
class Shares {
 public:
  Shares(std::vector<PoseIndex> begins, std::size_t poses) : begin_(std::move(begins)) { begin_.emplace_back(poses); }

  /// The rank to whose share a pose belongs; the later one of two.
  std::size_t owner(PoseIndex pose) const {
    return static_cast<std::size_t>(std::upper_bound(begin_.begin(), begin_.end() - 1, pose) - begin_.begin()) - 1;
  }
  /// The first and the last pose of a rank's share; the last one is the next share's first.
  PoseIndex first(std::size_t rank) const { return begin_[rank]; }
  PoseIndex last(std::size_t rank) const { return rank + 2 == begin_.size() ? begin_.back() - 1 : begin_[rank + 1]; }

 private:
  std::vector<PoseIndex> begin_;
};

/// The message to one rank: pose and feature factors of its log, then those of `apart`.
template <int Dim>
std::string dealt_to(std::size_t rank, const FactorGraph<Dim>& graph, const Shares& shares, std::size_t ranks) {
  const auto is_of_rank = [&](const PoseFactor<Dim>& o) {
    return shares.owner(o.base == kWorld ? o.target : std::min(o.base, o.target)) == rank;
  };
  const auto is_within = [&](const PoseFactor<Dim>& o) { return o.base != kWorld && later_pose(o) <= shares.last(rank); };
  return Writer()
      .put_if(graph.pose_factors, [&](const auto& o) { return is_of_rank(o) && is_within(o); })
      .put_if(graph.feature_factors, [&](const auto& o) { return o.base != kWorld && shares.owner(o.base) == rank; })
      .put_if(graph.pose_factors, [&](const auto& o) { return is_of_rank(o) && !is_within(o); })
      .put_if(graph.feature_factors, [&](const auto& o) { return o.base == kWorld && o.target.position() % ranks == rank; })
      .bytes();
}

/// Makes room for the factors that come from the ranks.
template <int Dim>
void reserve(const std::vector<std::string>& messages, LogBuilder<Dim>& builder) {
  std::size_t edges = 0;
  std::size_t observations = 0;
  for (const std::string& message : messages) {
    Reader reader(message);
    edges += reader.skip<PoseFactor<Dim>>();
    observations += reader.skip<FeatureFactor<Dim>>();
  }
  builder.reserve(edges, observations);
}

/// The share made of all that comes from the ranks.
template <int Dim>
LogShare<Dim> received(std::vector<std::string> messages, const LogPart<Dim>& part, PoseIndex first, PoseIndex last,
                       PoseOrder order) {
  LogShare<Dim> share;
  LogBuilder<Dim> builder(part.source, part.conventions, Numbers::kChecked);
  // Poses go by their index, for names need not ascend.
  const auto id = [&](PoseIndex pose) { return PoseId{part.poses[pose].session, static_cast<std::uint64_t>(pose.value)}; };
  for (PoseIndex pose = first; pose <= last; ++pose) builder.add_pose(id(pose));
  reserve(messages, builder);
  for (std::string& message : messages) {
    Reader reader(message);
    reader.for_each<PoseFactor<Dim>>(
        [&](const auto& o) { builder.add_pose_edge(id(o.base), id(o.target), o.measured, o.information); });
    reader.for_each<FeatureFactor<Dim>>(
        [&](const auto& o) { builder.add_observation(id(o.base), part.features[o.target], o.measured, o.information); });
    append(share.apart.pose_factors, reader.take<PoseFactor<Dim>>());
    append(share.apart.feature_factors, reader.take<FeatureFactor<Dim>>());
    release(message);
  }
  share.log = std::move(builder).finish(order).value();  // was checked when it was read
  for (PoseId& name : share.log.poses) {
    share.poses.emplace_back(name.key);
    name = part.poses[share.poses.back()];
  }
  for (const FeatureId& id : share.log.features) share.features.emplace_back(find_ascending(part.features, id).value());
  return share;
}

/// Marks the poses and features that others refer to.
template <int Dim>
void mark_referenced(const Communicator& comm, const LogPart<Dim>& part, const Shares& shares, LogShare<Dim>& share) {
  std::vector<PoseIndex> poses;
  std::vector<Holding> features;
  for (const auto& o : share.apart.pose_factors) {
    if (o.base != kWorld) poses.push_back(o.base);
    poses.push_back(o.target);
  }
  poses = comm.gather(poses);
  for (const auto& fixed : part.graph.fixed) poses.push_back(fixed.pose);
  for (int r = 1; r < comm.size(); ++r) poses.push_back(shares.first(static_cast<std::size_t>(r)));
  std::ranges::sort(poses);
  for (const PoseIndex p : share.poses) share.is_referenced.push_back(std::ranges::binary_search(poses, p));

  for (const FeatureIndex f : share.features) features.push_back({f.value, comm.rank()});
  const std::vector<Holding> shared = shared_holdings(comm, features, part.features.size());
  std::vector<std::int32_t> priors;
  for (const auto& o : share.apart.feature_factors) priors.push_back(o.target.value);
  priors = comm.gather(priors);
  std::ranges::sort(priors);
  for (const auto& [f, rank] : features) {
    share.is_referenced_feature.push_back(std::ranges::binary_search(shared, f, {}, &Holding::number) ||
                                          std::ranges::binary_search(priors, f));
  }
}

}  // namespace

std::vector<PoseIndex> even_begins(std::size_t poses, int ranks) {
  std::vector<PoseIndex> begins;
  for (int r = 0; r < ranks; ++r) begins.emplace_back(poses * static_cast<std::size_t>(r) / static_cast<std::size_t>(ranks));
  return begins;
}

template <int Dim>
LogShare<Dim> share_of(const Communicator& comm, LogPart<Dim>& part, const std::vector<PoseIndex>& begins, PoseOrder order) {
  const auto ranks = static_cast<std::size_t>(comm.size());
  const auto rank = static_cast<std::size_t>(comm.rank());
  const Shares shares(begins, part.poses.size());
  std::vector<std::string> messages;
  for (std::size_t r = 0; r < ranks; ++r) messages.push_back(dealt_to(r, part.graph, shares, ranks));
  release(part.graph.pose_factors);
  release(part.graph.feature_factors);
  LogShare<Dim> share = received(comm.exchange(std::move(messages)), part, shares.first(rank), shares.last(rank), order);
  mark_referenced(comm, part, shares, share);
  return share;
}

template LogShare<2> share_of(const Communicator&, LogPart<2>&, const std::vector<PoseIndex>&, PoseOrder);
template LogShare<3> share_of(const Communicator&, LogPart<3>&, const std::vector<PoseIndex>&, PoseOrder);

}  // namespace mapjoin::distributed
