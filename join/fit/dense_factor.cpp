// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/fit/dense_factor.hpp>

namespace mapjoin {
namespace {

template <int Dim, int Dof>
DenseFactor dense(const LinearObservation<Dim, Dof>& linear) {
  DenseFactor factor{linear.target.residual, linear.W, Eigen::MatrixXd(Dof, kPoseDof<Dim> + Dof)};
  factor.J << linear.target.J_base, linear.target.J_target;
  return factor;
}

template <int Dim>
DenseFactor dense(const LinearMap<Dim>& linear) {
  const Eigen::MatrixXd& W = linear.map->information;
  DenseFactor factor{Eigen::VectorXd(W.rows()), W, {}};
  factor.J.setZero(W.rows(), kPoseDof<Dim> + W.rows());
  Eigen::Index row = 0;
  linear.for_each_target([&]<int Dof>(int, const LinearTarget<Dim, Dof>& target) {
    factor.r.template segment<Dof>(row) = target.residual;
    factor.J.template block<Dof, kPoseDof<Dim>>(row, 0) = target.J_base;
    factor.J.template block<Dof, Dof>(row, kPoseDof<Dim> + row) = target.J_target;
    row += Dof;
  });
  return factor;
}

}  // namespace

template <int Dim>
DenseFactor dense_factor(const JoiningSystem<Dim>& system, std::size_t factor) {
  return system.with_linear_factor(factor, [](const auto& linear) { return dense(linear); });
}

template <int Dim>
Eigen::MatrixXd times(const Eigen::MatrixXd& J, const Eigen::Ref<const Eigen::MatrixXd>& X, std::size_t factor,
                      const NormalEquations& equations) {
  Eigen::MatrixXd product = Eigen::MatrixXd::Zero(J.rows(), X.cols());
  for_each_variable<Dim>(equations, factor, [&](Variable v, Eigen::Index column) {
    product += J.middleCols(column, equations.dof(v)) * X.middleRows(equations.offset(v), equations.dof(v));
  });
  return product;
}

#define MAPJOIN_INSTANTIATE(Dim)                                                                                     \
  template DenseFactor dense_factor(const JoiningSystem<Dim>&, std::size_t);                                         \
  template Eigen::MatrixXd times<Dim>(const Eigen::MatrixXd&, const Eigen::Ref<const Eigen::MatrixXd>&, std::size_t, \
                                      const NormalEquations&);
MAPJOIN_INSTANTIATE(2)
MAPJOIN_INSTANTIATE(3)
#undef MAPJOIN_INSTANTIATE

}  // namespace mapjoin
