// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Turns the columns of a step at x̂ into those of δ.
template <int Dim, int Rows>
void turn_into_delta(const JoinedVariable<Dim>& variable, Matrix<Rows, kPoseDof<Dim>>& J) {
  if constexpr (Dim == 3) J.template rightCols<3>() *= right_jacobian<3>(variable.step.template tail<3>());
}

/// Adds the blocks of one map at their rows of a quadratic, whose last row is that of FrontTree::kOne.
struct QuadraticSink {
  const std::vector<Eigen::Index>& rows;  // first row of each variable; -1 if anchored
  Eigen::MatrixXd& H;

  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    const Eigen::Index row = rows[static_cast<std::size_t>(j)];
    const Eigen::Index column = rows[static_cast<std::size_t>(i)];
    if (row < 0 || column < 0) return;
    H.block<Block::ColsAtCompileTime, Block::RowsAtCompileTime>(row, column) += block.transpose();
  }
  template <typename Block>
  void rhs(int i, const Block& block) {
    const Eigen::Index row = rows[static_cast<std::size_t>(i)];
    if (row >= 0) H.bottomRows<1>().template segment<Block::RowsAtCompileTime>(row) -= block.transpose();
  }
};

}  // namespace

template <int Dim>
void JoinedVariable<Dim>::move_to(const PoseVector<Dim>& new_step) {
  step = new_step;
  if (is_pose) {
    value = retract(reference, step);
  } else {
    value.translation = reference.translation + step.template head<Dim>();
  }
}

template <int Dim>
void JoinedVariable<Dim>::refer_to_value() {
  reference = value;
  step.setZero();
}

template <int Dim>
MapFactor<Dim>::MapFactor(const LocalMap<Dim>& map, std::vector<JoinedIndex> variables)
    : map_(&map), variables_(std::move(variables)), rows_(information_rank(map.information)) {}

template <int Dim>
const JoinedVariable<Dim>& MapFactor<Dim>::base_of(const JoinedVariables<Dim>& variables) const {
  static const JoinedVariable<Dim> world;
  return variables_[0] == kJoinedWorld ? world : variables[variables_[0]];
}

template <int Dim>
const JoinedVariable<Dim>& MapFactor<Dim>::target(const JoinedVariables<Dim>& variables, std::size_t t) const {
  return variables[variables_[1 + t]];
}

template <int Dim>
Quadratic MapFactor<Dim>::linearise(const JoinedVariables<Dim>& variables) {
  const JoinedVariable<Dim>& base = base_of(variables);
  base_turn_ = base.step.template tail<kRotationDof<Dim>>();
  linear_ = mapjoin::linearise(
      *map_, base.value, [&](std::size_t p) -> const Pose<Dim>& { return target(variables, p).value; },
      [&](std::size_t f) -> const Point<Dim>& { return target(variables, map_->poses.size() + f).value.translation; });
  std::size_t t = 0;
  const auto refer_to_delta = [&]<int Dof>(LinearTarget<Dim, Dof>& linear) {
    const JoinedVariable<Dim>& seen = target(variables, t++);
    turn_into_delta(base, linear.J_base);
    if constexpr (Dof == kPoseDof<Dim>) turn_into_delta(seen, linear.J_target);
    linear.residual += linear.J_target * seen.step.template head<Dof>() + linear.J_base * base.step;
  };
  std::for_each(linear_.poses.begin(), linear_.poses.end(), refer_to_delta);
  std::for_each(linear_.features.begin(), linear_.features.end(), refer_to_delta);

  Quadratic system;
  std::vector<Eigen::Index> rows;
  Eigen::Index size = 0;
  const auto add_variable = [&](const JoinedVariable<Dim>& variable) {
    const bool is_free = variable.column != kConstant;
    rows.push_back(is_free ? size : -1);
    if (is_free) system.variables.push_back(variable.column);
    if (is_free) size += variable.dof();
  };
  add_variable(base);
  for (t = 0; t + 1 < variables_.size(); ++t) add_variable(target(variables, t));
  system.variables.push_back(FrontTree::kOne);
  system.H.setZero(size + 1, size + 1);
  system.H(size, size) = accumulate(linear_, QuadraticSink{rows, system.H});
  return system;
}

template <int Dim>
Eigen::VectorXd MapFactor<Dim>::residual_at(const JoinedVariables<Dim>& variables) const {
  return residual(
      *map_, base_of(variables).value, [&](std::size_t p) { return target(variables, p).value; },
      [&](std::size_t f) { return target(variables, map_->poses.size() + f).value.translation; });
}

template <int Dim>
double MapFactor<Dim>::chi2(const JoinedVariables<Dim>& variables) const {
  return cost(*map_, residual_at(variables));
}

template <int Dim>
typename MapFactor<Dim>::Fit MapFactor<Dim>::fit(const JoinedVariables<Dim>& variables) const {
  const Eigen::VectorXd r = residual_at(variables);
  const JoinedVariable<Dim>& base = base_of(variables);
  Eigen::VectorXd error = r;
  linear_.for_each_target([&]<int Dof>(int t, const LinearTarget<Dim, Dof>& linear) {
    const auto k = static_cast<std::size_t>(t);
    error.template segment<Dof>(map_->row(k)) -=
        linear.residual - linear.J_target * target(variables, k).step.template head<Dof>() - linear.J_base * base.step;
  });
  Fit fit;
  fit.chi2 = cost(*map_, r);
  const double turned = (base.step.template tail<kRotationDof<Dim>>() - base_turn_).squaredNorm();
  fit.error = cost(*map_, error) + turned * fit.chi2;
  return fit;
}

template struct JoinedVariable<2>;
template struct JoinedVariable<3>;
template class MapFactor<2>;
template class MapFactor<3>;

}  // namespace mapjoin
