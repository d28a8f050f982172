// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/robust/support/odometry_chain.hpp>
#include <mapjoin/join/robust/weak_information.hpp>
#include <mapjoin/measure/statistics.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>
#include <vector>

namespace mapjoin {

template <int Dim>
PoseVector<Dim> weak_information(const Log<Dim>& log) {
  PoseVector<Dim> weak = information_within<Dim>(OdometryChain<Dim>(log).extent());
  for (int row = 0; row < kPoseDof<Dim>; ++row) {
    std::vector<double> measured;
    for (const PoseFactor<Dim>& edge : log.edges()) {
      if (edge.information(row, row) > 0.0) measured.push_back(edge.information(row, row));
    }
    if (!measured.empty()) weak[row] = kWeakShare * median(std::move(measured));
  }
  return weak;
}

template <int Dim>
void complete_weakly(PoseFactor<Dim>& edge, const PoseVector<Dim>& weak) {
  PoseMatrix<Dim>& W = edge.information;
  if (information_rank(W) == kPoseDof<Dim>) return;
  const PoseVector<Dim> own = W.diagonal();
  W.diagonal() += (own.array() > 0.0).select(kWeakShare * own, weak);
}

template PoseVector<2> weak_information(const Log<2>&);
template PoseVector<3> weak_information(const Log<3>&);
template void complete_weakly(PoseFactor<2>&, const PoseVector<2>&);
template void complete_weakly(PoseFactor<3>&, const PoseVector<3>&);

}  // namespace mapjoin
