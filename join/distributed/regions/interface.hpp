// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The unknowns that several regions share: their order, the same on all ranks, and which of them each region has.

#include <Eigen/Core>
#include <mapjoin/distributed/regions/region.hpp>
#include <mapjoin/solve/block_lower.hpp>

namespace mapjoin::distributed {

/// The poses and features that a region shares with others, in the order of its faces.
struct Border {
  std::vector<PoseOrFeature> places;   ///< Poses and features by their places in the region.
  std::vector<std::int32_t> unknowns;  ///< Numbers of their unknowns among those of all regions.
  std::vector<Column> faces;           ///< Indices in Interface::faces, ascending.
};

/// The unknowns of one rank's matrix that several ranks share: its last blocks.
struct OuterUnknowns {
  std::size_t size = 0;                ///< Number of such unknowns of all ranks.
  std::vector<std::int32_t> unknowns;  ///< Numbers of the unknowns of this rank's last blocks among these, ascending.
};

/// The interface of all regions. Unknowns of the same regions stand together (the faces, edges and corners of a mesh), in an
/// elimination order by which of these meet in a region. First are those that several ranks share, then those of the first
/// rank's regions alone, and so on.
struct Interface {
  std::size_t size = 0;         ///< Number of unknowns of the interfaces of all regions.
  std::vector<Border> borders;  ///< Borders of the regions of this rank.
  BlockLower faces;             ///< Pattern of the matrix over these borders, one block per face; faces of several ranks last.
  std::size_t outer_faces = 0;  ///< Number of faces of several ranks.
  OuterUnknowns outer;
};

template <int Dim>
Interface interface_of(const Communicator& comm, const Regions<Dim>& regions);

/// The entries of a region's vectors that belong to its border, in the order of its places.
template <int Dim>
std::vector<Eigen::Index> entries_of(const Border& border, const Region<Dim>& region);

}  // namespace mapjoin::distributed
