// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Lengths of vectors that are spread over regions: the regions of a rank stand one after the other, and entries that several
// regions share are in each of them.

#include <mapjoin/distributed/regions/interface.hpp>
#include <mapjoin/solve/trust_region.hpp>

namespace mapjoin::distributed {

/// The entries of a rank's vectors that other regions have, too.
struct SharedEntries {
  std::size_t size = 0;                ///< Number of unknowns of all interfaces.
  std::vector<Eigen::Index> entries;   ///< Indices in the vectors of this rank.
  std::vector<std::int32_t> unknowns;  ///< Numbers of these entries among all unknowns of interfaces.
};

/// The metric D = diag(H), a sum over the regions like H.
class RegionMetric {
 public:
  RegionMetric(const Communicator& comm, const SharedEntries& shared, Eigen::VectorXd diagonal)
      : comm_(comm), shared_(shared), own_(std::move(diagonal)) {}

  double inner(const Eigen::VectorXd& u, const Eigen::VectorXd& v) const { return comm_.sum(own_.inner(u, v)); }
  Eigen::VectorXd descent(const Eigen::VectorXd& gradient) const {
    return DiagonalMetric(assembled(own_.diagonal())).descent(assembled(gradient));
  }

 private:
  /// The vector with its interface entries summed over all regions.
  Eigen::VectorXd assembled(Eigen::VectorXd v) const {
    std::vector<double> sums(shared_.size, 0.0);
    const auto sum_of = [&](std::size_t k) -> double& { return sums[static_cast<std::size_t>(shared_.unknowns[k])]; };
    for (std::size_t k = 0; k < shared_.entries.size(); ++k) sum_of(k) += v[shared_.entries[k]];
    comm_.sum(sums);
    for (std::size_t k = 0; k < shared_.entries.size(); ++k) v[shared_.entries[k]] = sum_of(k);
    return v;
  }

  const Communicator& comm_;
  const SharedEntries& shared_;
  DiagonalMetric own_;
};

}  // namespace mapjoin::distributed
