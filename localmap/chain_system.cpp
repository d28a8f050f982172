// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <mapjoin/localmap/chain_system.hpp>
#include <mapjoin/solve/sparse_solver.hpp>

namespace mapjoin {

template <int Dim>
ChainSystem<Dim>::ChainSystem(Eigen::Index chain_length, Eigen::Index border_size)
    : D_(static_cast<std::size_t>(chain_length)),
      L_(static_cast<std::size_t>(chain_length)),
      E_(chain_length * kDof, border_size),
      C_(border_size, border_size),
      g_(chain_length * kDof + border_size) {
  set_zero();
}

template <int Dim>
void ChainSystem<Dim>::set_zero() {
  for (auto& block : D_) block.setZero();
  for (auto& block : L_) block.setZero();
  E_.setZero();
  C_.setZero();
  g_.setZero();
}

template <int Dim>
Eigen::VectorXd ChainSystem<Dim>::diagonal() const {
  Eigen::VectorXd diagonal(size());
  for (Eigen::Index k = 0; k < chain_length(); ++k) {
    diagonal.segment<kDof>(k * kDof) = D_[static_cast<std::size_t>(k)].diagonal();
  }
  diagonal.tail(border_size()) = C_.diagonal();
  return diagonal;
}

template <int Dim>
double ChainSystem<Dim>::curvature(const Eigen::VectorXd& v) const {
  const auto v_border = v.tail(border_size());
  double sum = 0.0;
  if (border_size() > 0) sum += v_border.dot(C_.template selfadjointView<Eigen::Upper>() * v_border);
  if (E_.size() > 0) sum += 2.0 * v.head(E_.rows()).dot(E_ * v_border);
  for (Eigen::Index k = 0; k < chain_length(); ++k) {
    const auto v_k = v.segment<kDof>(k * kDof);
    sum += v_k.dot(D_[static_cast<std::size_t>(k)] * v_k);
    if (k + 1 < chain_length()) sum += 2.0 * v_k.dot(L_[static_cast<std::size_t>(k)] * v.segment<kDof>((k + 1) * kDof));
  }
  return sum;
}

template <int Dim>
void ChainSystem<Dim>::damp(double damping) {
  for (auto& block : D_) block.diagonal() *= 1.0 + damping;
  C_.diagonal() *= 1.0 + damping;
}

template <int Dim>
bool ChainSystem<Dim>::eliminate_chain() {
  const Eigen::VectorXd scale = diagonal();
  for (Eigen::Index k = 0; k < chain_length(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    const Eigen::LLT<Matrix<kDof>> llt(D_[i]);
    if (llt.info() != Eigen::Success) return false;
    D_[i] = llt.matrixL();
    for (int j = 0; j < kDof; ++j) {
      if (has_lost_digits(D_[i](j, j), scale[k * kDof + j])) return false;
    }
    const auto G = D_[i].template triangularView<Eigen::Lower>();
    const bool is_last = k + 1 == chain_length();
    if (!is_last) {
      G.solveInPlace(L_[i]);
      D_[i + 1].noalias() -= L_[i].transpose() * L_[i];
    }
    if (border_size() == 0) continue;
    auto E_k = border_rows(k);
    G.solveInPlace(E_k);
    if (!is_last) border_rows(k + 1).noalias() -= L_[i].transpose() * E_k;
  }
  if (E_.size() > 0) C_.template selfadjointView<Eigen::Upper>().rankUpdate(E_.transpose(), -1.0);
  eliminate_gradient(g_);
  return true;
}

template <int Dim>
void ChainSystem<Dim>::eliminate_gradient(const Eigen::VectorXd& gradient) {
  g_ = gradient;
  for (Eigen::Index k = 0; k < chain_length(); ++k) {
    const auto i = static_cast<std::size_t>(k);
    auto g_k = g_.segment<kDof>(k * kDof);
    D_[i].template triangularView<Eigen::Lower>().solveInPlace(g_k);
    if (k + 1 < chain_length()) g_.segment<kDof>((k + 1) * kDof).noalias() -= L_[i].transpose() * g_k;
  }
  if (E_.size() > 0) g_.tail(border_size()).noalias() -= E_.transpose() * g_.head(E_.rows());
}

template <int Dim>
Eigen::VectorXd ChainSystem<Dim>::chain_step(const Eigen::VectorXd& border_step) const {
  Eigen::VectorXd step = g_.head(E_.rows());
  if (E_.size() > 0) step.noalias() -= E_ * border_step;
  for (Eigen::Index k = chain_length() - 1; k >= 0; --k) {
    auto step_k = step.segment<kDof>(k * kDof);
    if (k + 1 < chain_length()) step_k.noalias() -= L_[static_cast<std::size_t>(k)] * step.segment<kDof>((k + 1) * kDof);
    D_[static_cast<std::size_t>(k)].template triangularView<Eigen::Lower>().transpose().solveInPlace(step_k);
  }
  return step;
}

template class ChainSystem<2>;
template class ChainSystem<3>;

}  // namespace mapjoin
