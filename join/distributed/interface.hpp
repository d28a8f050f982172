// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The unknowns that several regions share: their order, the same on all ranks, and which of them this one has.

#include <Eigen/Core>
#include <mapjoin/distributed/region.hpp>

namespace mapjoin::distributed {

/// The interface of a region. Unknowns of the same regions stand together (the faces, edges and corners of a mesh), in an order
/// of elimination that comes from which of these meet in a region.
struct Interface {
  std::size_t size = 0;                ///< Unknowns of the interfaces of all regions.
  std::vector<PoseOrFeature> border;   ///< The poses and features of this region's, by their places in it, in this order.
  std::vector<std::int32_t> unknowns;  ///< Of these, the numbers among all, ascending.
};

template <int Dim>
Interface interface_of(const Communicator& comm, const Region<Dim>& region);

}  // namespace mapjoin::distributed
