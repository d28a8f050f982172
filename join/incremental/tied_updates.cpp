// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <mapjoin/graph/graph.hpp>
#include <mapjoin/join/incremental/tied_updates.hpp>

namespace mapjoin {
namespace {

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

#define MAPJOIN_INSTANTIATE(Dim)                                                                    \
  template std::vector<std::vector<std::size_t>> tied_updates(const std::deque<SubmapUpdate<Dim>>&, \
                                                              const std::vector<std::size_t>&, const NamedEstimate<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
