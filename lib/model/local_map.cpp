// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/model/local_map.hpp>

namespace mapjoin {

template <int Dim>
void use_identity_covariance(MapSet<Dim>& set) {
  for (auto& map : set.maps) map.information.setIdentity();
  for (auto& edge : set.pose_observations) edge.information.setIdentity();
  for (auto& observation : set.feature_observations) observation.information.setIdentity();
  set.conventions.covariance = Covariance::kIdentity;
}

template void use_identity_covariance(MapSet<2>&);
template void use_identity_covariance(MapSet<3>&);

}  // namespace mapjoin
