// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/join/incremental/front.hpp>
#include <mapjoin/solve/pivot.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Cholesky in place; false where H is singular to working precision.
bool factorise(Eigen::Ref<Eigen::MatrixXd> H) {
  const Eigen::VectorXd diagonal = H.diagonal();
  const Eigen::LLT<Eigen::Ref<Eigen::MatrixXd>> llt(H);
  if (llt.info() != Eigen::Success) return false;
  for (Eigen::Index j = 0; j < H.rows(); ++j) {
    if (has_lost_digits(H(j, j), diagonal[j])) return false;
  }
  return true;
}

/// The factor of H or, where that is singular, of H with the least damping of its diagonal that makes it regular.
void factorise_damped(Eigen::Ref<Eigen::MatrixXd> H) {
  const Eigen::MatrixXd undamped = H;
  for (double damping = 1e-8; !factorise(H); damping *= 10.0) {
    H = undamped;
    H.diagonal() += damping * undamped.diagonal().cwiseMax(1.0);
  }
}

}  // namespace

Front::Front(Quadratic whole, std::size_t frontal_count, Eigen::Index frontal_size) {
  const auto first_left = whole.variables.begin() + static_cast<std::ptrdiff_t>(frontal_count);
  frontals_.assign(whole.variables.begin(), first_left);
  message_.variables.assign(first_left, whole.variables.end());

  const Eigen::Index separator_size = whole.b.size() - frontal_size;
  L_ = whole.H.leftCols(frontal_size);
  factorise_damped(L_.topRows(frontal_size));
  const auto L_ff = L_.topRows(frontal_size).triangularView<Eigen::Lower>();
  y_ = L_ff.solve(whole.b.head(frontal_size));
  if (separator_size == 0) return;
  auto L_sf = L_.bottomRows(separator_size);
  L_ff.transpose().solveInPlace<Eigen::OnTheRight>(L_sf);
  message_.H = whole.H.bottomRightCorner(separator_size, separator_size);
  message_.H.selfadjointView<Eigen::Lower>().rankUpdate(L_sf, -1.0);
  message_.b = whole.b.tail(separator_size) - L_sf * y_;
}

Eigen::VectorXd Front::solve(const Eigen::VectorXd& separator_step) const {
  Eigen::VectorXd step = y_;
  step.noalias() -= L_.bottomRows(separator_step.size()).transpose() * separator_step;
  L_.topRows(step.size()).triangularView<Eigen::Lower>().transpose().solveInPlace(step);
  return step;
}

double Front::squared_deviations(const Eigen::VectorXd& v) const {
  return (L_.topRows(v.size()).triangularView<Eigen::Lower>().transpose() * v).squaredNorm();
}

}  // namespace mapjoin
