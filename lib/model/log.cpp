// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/model/log.hpp>

namespace mapjoin {

template <int Dim>
void use_identity_covariance(Log<Dim>& log) {
  for (auto* edges : {&log.odometry, &log.closures, &log.pose_priors}) {
    for (auto& edge : *edges) edge.information.setIdentity();
  }
  for (auto* observations : {&log.observations, &log.feature_priors}) {
    for (auto& observation : *observations) observation.information.setIdentity();
  }
  log.conventions.covariance = Covariance::kIdentity;
}

template void use_identity_covariance(Log<2>&);
template void use_identity_covariance(Log<3>&);

}  // namespace mapjoin
