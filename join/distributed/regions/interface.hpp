// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The unknowns that several regions share: their order, the same on all ranks, and which of them each region has.

#include <Eigen/Core>
#include <mapjoin/distributed/regions/region.hpp>
#include <mapjoin/solve/block_lower.hpp>

namespace mapjoin::distributed {

/// What a region shares with others, in the order of its faces.
struct Border {
  std::vector<PoseOrFeature> places;   ///< Poses and features by their places in the region.
  std::vector<std::int32_t> unknowns;  ///< The numbers of their unknowns among those of all regions.
  std::vector<Column> faces;           ///< Of Interface::faces, ascending.
};

/// What several ranks share of the matrix of one: its last blocks.
struct OuterUnknowns {
  std::size_t size = 0;                ///< Of all ranks.
  std::vector<std::int32_t> unknowns;  ///< Of this rank's last blocks, the numbers among all, ascending.
};

/// Unknowns of the same regions stand together (the faces, edges and corners of a mesh), in an order of elimination that comes
/// from which of these meet in a region. First are those that several ranks share, then those of the first rank's regions
/// alone, and so on.
struct Interface {
  std::size_t size = 0;         ///< Unknowns of the interfaces of all regions.
  std::vector<Border> borders;  ///< Of the regions of this rank.
  BlockLower faces;             ///< The pattern of what they share, a block for a face; those of several ranks last.
  std::size_t outer_faces = 0;  ///< How many these are.
  OuterUnknowns outer;
};

template <int Dim>
Interface interface_of(const Communicator& comm, const Regions<Dim>& regions);

/// The entries of a region's vectors that its border has, in the order of its places.
template <int Dim>
std::vector<Eigen::Index> entries_of(const Border& border, const Region<Dim>& region);

}  // namespace mapjoin::distributed
