// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/distributed/region_metric.hpp>

namespace mapjoin::distributed {

Eigen::VectorXd RegionMetric::assembled(Eigen::VectorXd v) const {
  std::vector<double> sums(shared_.size, 0.0);
  const auto sum_of = [&](std::size_t k) -> double& { return sums[static_cast<std::size_t>(shared_.unknowns[k])]; };
  for (std::size_t k = 0; k < shared_.entries.size(); ++k) sum_of(k) += v[shared_.entries[k]];
  comm_.sum(sums);
  for (std::size_t k = 0; k < shared_.entries.size(); ++k) v[shared_.entries[k]] = sum_of(k);
  return v;
}

}  // namespace mapjoin::distributed
