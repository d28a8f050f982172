// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/localmap/split_cost.hpp>

namespace mapjoin {

template <int Dim>
Index cheapest_poses_per_map(const Log<Dim>&) {
  return 10;
}

template Index cheapest_poses_per_map(const Log<2>&);
template Index cheapest_poses_per_map(const Log<3>&);

}  // namespace mapjoin
