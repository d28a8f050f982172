// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/solve/chain_given_border.hpp>

namespace mapjoin {

template <int Dim>
ChainGivenBorder<Dim>::ChainGivenBorder(const ChainSystem<Dim>& eliminated)
    : gain_(eliminated.chain_length() * kDof, eliminated.border_size()),
      covariances_(static_cast<std::size_t>(eliminated.chain_length())),
      transfers_(covariances_.size(), Matrix<kDof>::Zero()) {
  for (Eigen::Index k = eliminated.chain_length() - 1; k >= 0; --k) {
    const auto i = static_cast<std::size_t>(k);
    const auto G = eliminated.diagonal_block(k).template triangularView<Eigen::Lower>();
    const Matrix<kDof> G_inverse = G.solve(Matrix<kDof>::Identity());
    covariances_[i] = G_inverse.transpose() * G_inverse;
    auto M_k = gain_.template middleRows<kDof>(k * kDof);
    M_k.noalias() = -(G_inverse.transpose() * eliminated.border_rows(k));
    if (k + 1 == eliminated.chain_length()) continue;
    transfers_[i] = -(G_inverse.transpose() * eliminated.coupling(k));
    M_k.noalias() += transfers_[i] * gain_.template middleRows<kDof>((k + 1) * kDof);
    covariances_[i] += transfers_[i] * covariances_[i + 1] * transfers_[i].transpose();
  }
}

template <int Dim>
Eigen::MatrixXd ChainGivenBorder<Dim>::covariance(std::span<const Eigen::Index> poses) const {
  const auto size = static_cast<Eigen::Index>(poses.size()) * kDof;
  Eigen::MatrixXd joint(size, size);
  for (std::size_t b = 0; b < poses.size(); ++b) {
    Eigen::Index k = poses[b];
    Matrix<kDof> block = covariances_[static_cast<std::size_t>(k)];  // cov(e_k, e_m) of m = poses[b]
    const auto column = static_cast<Eigen::Index>(b) * kDof;
    for (std::size_t a = b + 1; a-- > 0;) {
      for (; k > poses[a]; --k) block = transfers_[static_cast<std::size_t>(k - 1)] * block;
      const auto row = static_cast<Eigen::Index>(a) * kDof;
      joint.block<kDof, kDof>(row, column) = block;
      joint.block<kDof, kDof>(column, row) = block.transpose();
    }
  }
  return joint;
}

template class ChainGivenBorder<2>;
template class ChainGivenBorder<3>;

}  // namespace mapjoin
