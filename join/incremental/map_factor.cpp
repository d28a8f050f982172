// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/LU>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/model/information.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// Turns the columns of a step at x̂ into those of δ: R Exp(δ̂ + dδ) = R Exp(δ̂) Exp(J dδ + …) with the right Jacobian J.
template <int Dim, int Rows>
void turn_into_delta(const JoinedVariable<Dim>& variable, Matrix<Rows, kPoseDof<Dim>>& J) {
  if constexpr (Dim == 3) {
    const RotationVector<3> rotation = variable.step.template tail<3>();
    J.template rightCols<3>() *= right_jacobian_inverse(rotation).inverse();
  }
}

/// Takes the blocks of one map to their rows in a dense system.
class DenseSink {
 public:
  DenseSink(const std::vector<Eigen::Index>& rows, Quadratic& system) : rows_(rows), system_(system) {}

  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    const Eigen::Index row = rows_[static_cast<std::size_t>(j)];
    const Eigen::Index column = rows_[static_cast<std::size_t>(i)];
    if (row < 0 || column < 0) return;
    constexpr int kRows = Block::ColsAtCompileTime;
    constexpr int kColumns = Block::RowsAtCompileTime;
    system_.H.template block<kRows, kColumns>(row, column) += block.transpose();
  }
  template <typename Block>
  void rhs(int i, const Block& block) {
    const Eigen::Index row = rows_[static_cast<std::size_t>(i)];
    if (row >= 0) system_.b.template segment<Block::RowsAtCompileTime>(row) += block;
  }

 private:
  const std::vector<Eigen::Index>& rows_;  // per slot; -1 where it is held
  Quadratic& system_;
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
MapFactor<Dim>::MapFactor(const LocalMap<Dim>& map, std::vector<Index> slots)
    : map_(&map), slots_(std::move(slots)), rows_(information_rank(map.information)), steps_(slots_.size()) {
  linear_.map = map_;
  linear_.poses.resize(map.poses.size());
  linear_.features.resize(map.features.size());
}

template <int Dim>
Pose<Dim> MapFactor<Dim>::base_of(const JoinedVariables<Dim>& variables) const {
  return slots_[0] == kWorld ? Pose<Dim>{} : variables[static_cast<std::size_t>(slots_[0])].value;
}

template <int Dim>
Quadratic MapFactor<Dim>::linearise(const JoinedVariables<Dim>& variables) {
  const auto variable = [&](std::size_t slot) -> const JoinedVariable<Dim>& {
    return variables[static_cast<std::size_t>(slots_[slot])];
  };
  Quadratic system;
  std::vector<Eigen::Index> rows;
  Eigen::Index size = 0;
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    const bool is_free = slots_[s] != kWorld && variable(s).column != kConstant;
    rows.push_back(is_free ? size : -1);
    if (slots_[s] != kWorld) steps_[s] = variable(s).step;
    if (!is_free) continue;
    system.variables.push_back(variable(s).column);
    size += variable(s).dof();
  }

  const Pose<Dim> base = base_of(variables);
  const auto in_delta = [&](auto& linear) {
    if (slots_[0] != kWorld) turn_into_delta(variable(0), linear.J_base);
  };
  for (std::size_t p = 0; p < map_->poses.size(); ++p) {
    const JoinedVariable<Dim>& target = variable(1 + p);
    linear_.poses[p] = mapjoin::linearise<Dim>(map_->pose_estimates[p], base, target.value);
    in_delta(linear_.poses[p]);
    turn_into_delta(target, linear_.poses[p].J_target);
  }
  for (std::size_t f = 0; f < map_->features.size(); ++f) {
    const Point<Dim>& target = variable(1 + map_->poses.size() + f).value.translation;
    linear_.features[f] = mapjoin::linearise<Dim>(map_->feature_estimates[f], base, target);
    in_delta(linear_.features[f]);
  }

  system.H.setZero(size, size);
  system.b.setZero(size);
  accumulate(linear_, DenseSink(rows, system));
  Eigen::VectorXd steps(size);
  for (std::size_t s = 0; s < slots_.size(); ++s) {
    if (rows[s] >= 0) steps.segment(rows[s], variable(s).dof()) = steps_[s].head(variable(s).dof());
  }
  system.b += system.H.template selfadjointView<Eigen::Lower>() * steps;
  return system;
}

template <int Dim>
Eigen::VectorXd MapFactor<Dim>::residual_at(const JoinedVariables<Dim>& variables) const {
  const auto value = [&](std::size_t slot) -> const Pose<Dim>& {
    return variables[static_cast<std::size_t>(slots_[slot])].value;
  };
  return residual(
      *map_, base_of(variables), [&](std::size_t p) { return value(1 + p); },
      [&](std::size_t f) { return value(1 + map_->poses.size() + f).translation; });
}

template <int Dim>
double MapFactor<Dim>::chi2(const JoinedVariables<Dim>& variables) const {
  return cost(*map_, residual_at(variables));
}

template <int Dim>
PoseVector<Dim> MapFactor<Dim>::moved(const JoinedVariables<Dim>& variables, std::size_t slot) const {
  return variables[static_cast<std::size_t>(slots_[slot])].step - steps_[slot];
}

template <int Dim>
typename MapFactor<Dim>::Fit MapFactor<Dim>::fit(const JoinedVariables<Dim>& variables) const {
  const Eigen::VectorXd r = residual_at(variables);
  const PoseVector<Dim> base_moved = slots_[0] == kWorld ? PoseVector<Dim>(PoseVector<Dim>::Zero()) : moved(variables, 0);
  Eigen::VectorXd error = r;
  Eigen::Index row = 0;
  for (std::size_t p = 0; p < linear_.poses.size(); ++p, row += kPoseDof<Dim>) {
    const auto& linear = linear_.poses[p];
    error.template segment<kPoseDof<Dim>>(row) -=
        linear.residual - linear.J_target * moved(variables, 1 + p) - linear.J_base * base_moved;
  }
  for (std::size_t f = 0; f < linear_.features.size(); ++f, row += Dim) {
    const auto& linear = linear_.features[f];
    const Point<Dim> target_moved = moved(variables, 1 + linear_.poses.size() + f).template head<Dim>();
    error.template segment<Dim>(row) -= linear.residual - linear.J_target * target_moved - linear.J_base * base_moved;
  }
  Fit fit;
  fit.chi2 = cost(*map_, r);
  fit.error = cost(*map_, error) + base_moved.template tail<kRotationDof<Dim>>().squaredNorm() * fit.chi2;
  return fit;
}

template struct JoinedVariable<2>;
template struct JoinedVariable<3>;
template class MapFactor<2>;
template class MapFactor<3>;

}  // namespace mapjoin
