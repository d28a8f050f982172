// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/distributed/regions/interface.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/ordering.hpp>
#include <span>

namespace mapjoin::distributed {
namespace {

using Holders = std::vector<std::int32_t>;

/// Poses and features that the same regions share.
struct Face {
  Holders regions;
  std::vector<std::int32_t> numbers;
  std::size_t first_unknown = 0;
  std::size_t size = 0;  ///< Number of unknowns.
};

/// The faces of shared poses and features that are not anchored.
std::vector<Face> faces_of(const std::vector<Holding>& shared, const std::vector<std::int32_t>& anchored) {
  std::map<Holders, std::vector<std::int32_t>> faces;
  for (auto first = shared.begin(); first != shared.end();) {
    const auto last = std::find_if(first, shared.end(), [&](const Holding& h) { return h.number != first->number; });
    Holders regions;
    std::for_each(first, last, [&](const Holding& h) { regions.push_back(h.holder); });
    if (!std::ranges::binary_search(anchored, first->number)) faces[regions].push_back(first->number);
    first = last;
  }
  std::vector<Face> list;
  for (auto& [regions, numbers] : faces) list.push_back({regions, std::move(numbers)});
  return list;
}

bool meet(const Face& a, const Face& b) {
  return std::ranges::find_first_of(a.regions, b.regions) != a.regions.end();
}

/// The faces in an order of elimination that keeps the factor small.
std::vector<Face> in_order(const std::vector<Face>& faces) {
  BlockGraph graph;
  for (std::size_t a = 0; a < faces.size(); ++a) {
    std::vector<Variable> neighbours;
    for (std::size_t b = 0; b < faces.size(); ++b) {
      if (a != b && meet(faces[a], faces[b])) neighbours.emplace_back(b);
    }
    graph.push_back(neighbours);
  }
  std::vector<Face> ordered;
  for (const Variable v : elimination_order(graph)) ordered.push_back(faces[v.position()]);
  return ordered;
}

/// The only rank of a face; -1 if there are several.
template <typename RankOf>
std::int32_t rank_of_face(const Face& face, RankOf&& rank_of) {
  const std::int32_t rank = rank_of(face.regions.front());
  const bool is_inner = std::ranges::all_of(face.regions, [&](std::int32_t region) { return rank_of(region) == rank; });
  return is_inner ? rank : -1;
}

/// Numbers the unknowns of faces from `next` on.
template <int Dim>
void number_unknowns(const Numbering& n, std::size_t& next, std::vector<Face>& faces) {
  for (Face& face : faces) {
    face.first_unknown = next;
    for (const std::int32_t number : face.numbers)
      face.size += static_cast<std::size_t>(std::holds_alternative<PoseIndex>(n.index(number)) ? kPoseDof<Dim> : Dim);
    next += face.size;
  }
}

/// The border of a region: its faces among those of its rank.
template <int Dim>
Border border_of(const Region<Dim>& region, std::int32_t number, const Numbering& n, const std::vector<Face>& faces) {
  Border border;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    if (!std::ranges::binary_search(faces[f].regions, number)) continue;
    border.faces.emplace_back(f);
    for (const std::int32_t shared : faces[f].numbers) {
      std::visit([&](auto index) { border.places.emplace_back(place_in(region, index)); }, n.index(shared));
    }
    for (std::size_t i = 0; i < faces[f].size; ++i)
      border.unknowns.push_back(static_cast<std::int32_t>(faces[f].first_unknown + i));
  }
  return border;
}

/// The pattern of the matrix over faces, in which those of each border are coupled.
BlockLower pattern_of(const std::vector<Face>& faces, const std::vector<Border>& borders) {
  std::vector<std::vector<Column>> below(faces.size());
  for (std::size_t f = 0; f < faces.size(); ++f) below[f].emplace_back(f);
  for (const Border& border : borders) {
    for (std::size_t a = 0; a < border.faces.size(); ++a) {
      append(below[border.faces[a].position()], std::span(border.faces).subspan(a + 1));
    }
  }
  BlockLower pattern;
  for (std::size_t f = 0; f < faces.size(); ++f) {
    make_distinct(below[f]);
    pattern.offsets.push_back(pattern.offsets.back() + static_cast<Eigen::Index>(faces[f].size));
    pattern.rows.push_back(below[f]);
  }
  return pattern;
}

}  // namespace

template <int Dim>
Interface interface_of(const Communicator& comm, const Regions<Dim>& regions) {
  const Numbering& n = regions.numbering;
  const auto per_rank = static_cast<std::int32_t>(regions.per_rank);
  std::vector<std::int32_t> anchored;  // of all regions
  for (const auto& region : regions.own) {
    for (const PoseIndex place : region.anchored) anchored.push_back(n.number(region.poses[place]));
  }
  anchored = comm.gather(anchored);
  std::ranges::sort(anchored);
  std::vector<Face> outer;
  std::vector<std::vector<Face>> inner(static_cast<std::size_t>(comm.size()));
  for (Face& face : faces_of(regions.shared, anchored)) {
    const std::int32_t rank = rank_of_face(face, [&](std::int32_t region) { return region / per_rank; });
    (rank < 0 ? outer : inner[static_cast<std::size_t>(rank)]).push_back(std::move(face));
  }
  Interface interface;
  outer = in_order(outer);
  number_unknowns<Dim>(n, interface.size, outer);
  interface.outer.size = interface.size;
  for (std::vector<Face>& faces : inner) {
    faces = in_order(faces);
    number_unknowns<Dim>(n, interface.size, faces);
  }
  const std::int32_t first_region = comm.rank() * per_rank;
  std::vector<Face> own = std::move(inner[static_cast<std::size_t>(comm.rank())]);
  for (Face& face : outer) {
    const auto first_own = std::ranges::lower_bound(face.regions, first_region);
    if (first_own == face.regions.end() || *first_own >= first_region + per_rank) continue;
    for (std::size_t i = 0; i < face.size; ++i) {
      interface.outer.unknowns.push_back(static_cast<std::int32_t>(face.first_unknown + i));
    }
    own.push_back(std::move(face));
    ++interface.outer_faces;
  }
  for (std::int32_t k = 0; k < per_rank; ++k) {
    interface.borders.push_back(border_of(regions.own[static_cast<std::size_t>(k)], first_region + k, n, own));
  }
  interface.faces = pattern_of(own, interface.borders);
  return interface;
}

template <int Dim>
std::vector<Eigen::Index> entries_of(const Border& border, const Region<Dim>& region) {
  const StateVariables<Dim> variables = variables_of(region);
  std::vector<Eigen::Index> entries;
  for (const PoseOrFeature& placed : border.places) {
    const Variable v = variables(placed);
    for (int i = 0; i < variables.dof(v); ++i) entries.push_back(variables.offset(v) + i);
  }
  return entries;
}

#define MAPJOIN_INSTANTIATE(Dim)                                             \
  template Interface interface_of(const Communicator&, const Regions<Dim>&); \
  template std::vector<Eigen::Index> entries_of(const Border&, const Region<Dim>&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin::distributed
