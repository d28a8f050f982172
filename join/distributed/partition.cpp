// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/distributed/partition.hpp>
#include <mapjoin/solve/ordering.hpp>

namespace mapjoin::distributed {
namespace {

constexpr std::size_t kMostRuns = 1'000'000;

/// The vertices: runs of poses, then features.
struct Vertices {
  Vertices(std::size_t pose_count, std::size_t feature_count)
      : poses(pose_count),
        features(feature_count),
        run_length(std::max<std::size_t>(1, (pose_count + kMostRuns - 1) / kMostRuns)),
        runs((pose_count + run_length - 1) / run_length) {}

  std::size_t size() const { return runs + features; }
  Variable run(PoseIndex pose) const { return Variable(pose.position() / run_length); }
  Variable feature(FeatureIndex feature) const { return Variable(runs + feature.position()); }
  /// Regions are to have as many poses.
  Table<Variable, std::int32_t> weights() const {
    Table<Variable, std::int32_t> weights(size(), 0);
    for (PoseIndex p = 0; p.position() < poses; ++p) ++weights[run(p)];
    return weights;
  }

  std::size_t poses, features, run_length, runs;
};

/// Two vertices that some measurement ties.
struct Tie {
  std::int32_t a = 0;
  std::int32_t b = 0;
  auto operator<=>(const Tie&) const = default;
};
template <typename F>
void fields(Tie& tie, const F& f) {
  f(tie.a);
  f(tie.b);
}

/// The different ties of a share, in both directions.
template <int Dim>
std::vector<Tie> ties_of(const Vertices& of, const LogShare<Dim>& share) {
  std::vector<Tie> ties;
  const auto add = [&](Variable a, Variable b) {
    if (a == b) return;
    ties.push_back({a.value, b.value});
    ties.push_back({b.value, a.value});
  };
  for (const auto& o : share.log.edges()) add(of.run(share.poses[o.base]), of.run(share.poses[o.target]));
  for (const auto& o : share.log.observations()) add(of.run(share.poses[o.base]), of.feature(share.features[o.target]));
  for (const auto& o : share.apart.pose_factors) {
    if (o.base != kWorld) add(of.run(o.base), of.run(o.target));
  }
  std::ranges::sort(ties);
  ties.erase(std::unique(ties.begin(), ties.end()), ties.end());
  return ties;
}

/// The graph of all ranks' ties, which are ascending.
BlockGraph graph_of(const std::vector<std::string>& messages, std::size_t vertices) {
  std::vector<Tie> ties;
  for (const std::string& message : messages) {
    const std::vector<Tie> some = Reader(message).take<Tie>();
    const auto middle = static_cast<std::ptrdiff_t>(ties.size());
    ties.insert(ties.end(), some.begin(), some.end());
    std::inplace_merge(ties.begin(), ties.begin() + middle, ties.end());
  }
  ties.erase(std::unique(ties.begin(), ties.end()), ties.end());
  BlockGraph graph;
  std::vector<Variable> neighbours;
  auto tie = ties.begin();
  for (std::int32_t v = 0; v < static_cast<std::int32_t>(vertices); ++v) {
    neighbours.clear();
    for (; tie != ties.end() && tie->a == v; ++tie) neighbours.emplace_back(tie->b);
    graph.push_back(neighbours);
  }
  return graph;
}

}  // namespace

template <int Dim>
Table<PoseIndex, std::size_t> region_of_poses(const Communicator& comm, const LogPart<Dim>& whole, const LogShare<Dim>& share,
                                              std::size_t count) {
  const Vertices of(whole.poses.size(), whole.features.size());
  std::vector<std::string> to(static_cast<std::size_t>(comm.size()));
  to.front() = Writer().put(ties_of(of, share)).bytes();
  const std::vector<std::string> messages = comm.exchange(std::move(to));
  std::string parts;
  if (comm.is_root()) {
    parts = Writer().put(partition(graph_of(messages, of.size()), of.weights(), static_cast<std::int32_t>(count))).bytes();
  }
  parts = comm.broadcast(std::move(parts), 0);
  const Table<Variable, std::int32_t> part(Reader(parts).take<std::int32_t>());
  Table<PoseIndex, std::size_t> regions;
  for (const PoseIndex p : share.poses) regions.push_back(static_cast<std::size_t>(part[of.run(p)]));
  return regions;
}

template Table<PoseIndex, std::size_t> region_of_poses(const Communicator&, const LogPart<2>&, const LogShare<2>&, std::size_t);
template Table<PoseIndex, std::size_t> region_of_poses(const Communicator&, const LogPart<3>&, const LogShare<3>&, std::size_t);

}  // namespace mapjoin::distributed
