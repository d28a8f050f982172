// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/kept_estimate.hpp>

namespace mapjoin {

template <int Dim>
void ShownVariables<Dim>::note_moving(JoinedIndex v) {
  if (v.position() >= shown_.size() || is_moving_[v]) return;
  is_moving_[v] = true;
  moving_.push_back(v);
}

template <int Dim>
StepSize ShownVariables<Dim>::show(const JoinedVariables<Dim>& variables) {
  const auto shown = [&](JoinedIndex v) -> Variable {
    const JoinedVariable<Dim>& is = variables[v];
    return {is.is_pose, is.value, is.step.template tail<kRotationDof<Dim>>(), is.column};
  };
  StepSize size;
  for (const JoinedIndex v : moving_) {
    const PoseVector<Dim> step = local(shown_[v].value, variables[v].value);
    size.metres = std::max(size.metres, step.template head<Dim>().norm());
    if (variables[v].is_pose) size.radians = std::max(size.radians, step.template tail<kRotationDof<Dim>>().norm());
    shown_.writable(v) = shown(v);
    is_moving_[v] = false;
  }
  moving_.clear();
  while (shown_.size() < variables.size()) shown_.push_back(shown(JoinedIndex(shown_.size())));
  is_moving_.resize(shown_.size(), false);
  return size;
}

template <int Dim>
std::optional<Eigen::MatrixXd> KeptEstimate<Dim>::covariance(std::span<const JoinedIndex> of) const {
  std::vector<mapjoin::Variable> columns;
  Eigen::Index size = 0;
  for (const JoinedIndex v : of) {
    if (variables[v].column != kConstant) columns.push_back(variables[v].column);
    size += variables[v].dof();
  }
  const auto of_free = factor.covariance(columns, deferred.get());  // of δ
  if (!of_free) return std::nullopt;
  Eigen::MatrixXd J_step_delta = Eigen::MatrixXd::Zero(size, of_free->rows());
  Eigen::Index row = 0;
  Eigen::Index column = 0;
  for (const JoinedIndex v : of) {
    const int dof = variables[v].dof();
    if (variables[v].column != kConstant) {
      auto J = J_step_delta.block(row, column, dof, dof);
      J.setIdentity();
      if (variables[v].is_pose)
        J.template bottomRightCorner<kRotationDof<Dim>, kRotationDof<Dim>>() = right_jacobian<Dim>(variables[v].turn);
      column += dof;
    }
    row += dof;
  }
  return Eigen::MatrixXd(J_step_delta * *of_free * J_step_delta.transpose());
}

template class ShownVariables<2>;
template class ShownVariables<3>;
template struct KeptEstimate<2>;
template struct KeptEstimate<3>;

}  // namespace mapjoin
