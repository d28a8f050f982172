// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/distributed/interface.hpp>
#include <mapjoin/solve/ordering.hpp>

namespace mapjoin::distributed {
namespace {

using Ranks = std::vector<std::int32_t>;
/// What the same regions share, by these regions.
using Faces = std::map<Ranks, std::vector<std::int32_t>>;

Faces faces_of(const std::vector<Holding>& shared) {
  Faces faces;
  for (auto first = shared.begin(); first != shared.end();) {
    const auto last = std::find_if(first, shared.end(), [&](const Holding& h) { return h.number != first->number; });
    Ranks ranks;
    std::for_each(first, last, [&](const Holding& h) { ranks.push_back(h.rank); });
    faces[ranks].push_back(first->number);
    first = last;
  }
  return faces;
}

bool meet(const Ranks& a, const Ranks& b) {
  return std::ranges::find_first_of(a, b) != a.end();
}

/// The faces in an order of elimination that keeps the factor small.
std::vector<Faces::const_iterator> in_order(const Faces& faces) {
  std::vector<Faces::const_iterator> all;
  for (auto face = faces.begin(); face != faces.end(); ++face) all.push_back(face);
  BlockGraph graph;
  for (const auto& a : all) {
    std::vector<Variable> neighbours;
    for (std::size_t b = 0; b < all.size(); ++b) {
      if (a != all[b] && meet(a->first, all[b]->first)) neighbours.emplace_back(b);
    }
    graph.push_back(neighbours);
  }
  std::vector<Faces::const_iterator> ordered;
  for (const Variable v : elimination_order(graph)) ordered.push_back(all[v.position()]);
  return ordered;
}

}  // namespace

template <int Dim>
Interface interface_of(const Communicator& comm, const Region<Dim>& region) {
  const Numbering& n = region.numbering;
  std::vector<std::int32_t> anchored;  // of all regions
  for (const PoseIndex place : region.gauge.anchored) anchored.push_back(n.number(region.partial.poses[place]));
  anchored = comm.gather(anchored);
  std::ranges::sort(anchored);
  Interface interface;
  const Faces faces = faces_of(region.interface);
  for (const auto& face : in_order(faces)) {
    const bool is_own = std::ranges::binary_search(face->first, comm.rank());
    for (const std::int32_t number : face->second) {
      if (std::ranges::binary_search(anchored, number)) continue;
      const int dof = n.is_pose(number) ? kPoseDof<Dim> : Dim;
      for (int i = 0; is_own && i < dof; ++i) interface.unknowns.push_back(static_cast<std::int32_t>(interface.size) + i);
      interface.size += static_cast<std::size_t>(dof);
      if (!is_own) continue;
      if (n.is_pose(number)) {
        interface.border.emplace_back(place_of(region.partial.poses, n.pose(number)));
      } else {
        interface.border.emplace_back(place_of(region.partial.features, n.feature(number)));
      }
    }
  }
  return interface;
}

template Interface interface_of(const Communicator&, const Region<2>&);
template Interface interface_of(const Communicator&, const Region<3>&);

}  // namespace mapjoin::distributed
