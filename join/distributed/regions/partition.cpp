// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/regions/dealer.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/ordering.hpp>

namespace mapjoin::distributed {
namespace {

constexpr std::size_t kMostRuns = 1'000'000;

/// The vertices of the graph: runs of poses, then features.
struct Vertices {
  Vertices(std::size_t pose_count, std::size_t feature_count)
      : poses(pose_count),
        features(feature_count),
        run_length(std::max<std::size_t>(1, (pose_count + kMostRuns - 1) / kMostRuns)),
        runs((pose_count + run_length - 1) / run_length) {}

  std::size_t size() const { return runs + features; }
  Variable run(PoseIndex pose) const { return Variable(pose.position() / run_length); }
  Variable feature(FeatureIndex feature) const { return Variable(runs + feature.position()); }
  /// Weights of the vertices, by number of poses: regions are to have equally many.
  Table<Variable, std::int32_t> weights() const {
    Table<Variable, std::int32_t> weights(size(), 0);
    for (PoseIndex p = 0; p.position() < poses; ++p) ++weights[run(p)];
    return weights;
  }

  std::size_t poses, features, run_length, runs;
};

/// The distinct links of a share, in both directions.
template <int Dim>
std::vector<Link> links_of(const Vertices& of, const LogShare<Dim>& share) {
  std::vector<Link> links;
  const auto add = [&](Variable a, Variable b) {
    if (a == b) return;
    links.push_back({a.value, b.value});
    links.push_back({b.value, a.value});
  };
  for (const auto& o : share.log.edges()) add(of.run(share.poses[o.base]), of.run(share.poses[o.target]));
  for (const auto& o : share.log.observations()) add(of.run(share.poses[o.base]), of.feature(share.features[o.target]));
  for (const auto& o : share.apart.pose_factors) {
    if (o.base != kWorld) add(of.run(o.base), of.run(o.target));
  }
  make_distinct(links);
  return links;
}

/// The graph of the links of all ranks.
BlockGraph graph_of(const std::vector<std::string>& messages, std::size_t vertices) {
  std::vector<Link> links;
  for (const std::string& message : messages) append(links, Reader(message).take<Link>());
  make_distinct(links);
  BlockGraph graph;
  std::vector<Variable> neighbours;
  auto link = links.begin();
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(vertices); ++v) {
    neighbours.clear();
    for (; link != links.end() && link->a == v; ++link) neighbours.emplace_back(link->b);
    graph.push_back(neighbours);
  }
  return graph;
}

}  // namespace

template <int Dim>
Table<PoseIndex, std::int32_t> region_of_poses(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                               std::size_t count) {
  const Vertices of(whole.poses.size(), whole.features.size());
  const std::vector<std::string> messages = comm.collect(Writer().put(links_of(of, share)).bytes());
  std::string parts;
  if (comm.is_root()) {
    parts = Writer().put(partition(graph_of(messages, of.size()), of.weights(), static_cast<std::int32_t>(count))).bytes();
  }
  parts = comm.broadcast(std::move(parts), 0);
  const Table<Variable, std::int32_t> part(Reader(parts).take<std::int32_t>());
  Table<PoseIndex, std::int32_t> regions;
  for (const PoseIndex p : indices(whole.poses)) regions.push_back(part[of.run(p)]);
  return regions;
}

template Table<PoseIndex, std::int32_t> region_of_poses(const Communicator&, const LogPart<2>&, const LogShare<2>&,
                                                        std::size_t);
template Table<PoseIndex, std::int32_t> region_of_poses(const Communicator&, const LogPart<3>&, const LogShare<3>&,
                                                        std::size_t);

}  // namespace mapjoin::distributed
