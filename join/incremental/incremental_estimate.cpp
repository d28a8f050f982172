// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/incremental/incremental_estimate.hpp>
#include <utility>

namespace mapjoin {
namespace {

constexpr int kMostIterations = 50;
/// Of a linearisation, in chi2 per measured row: 0.3 % of a standard deviation. An estimate at which no map errs by more is
/// above the optimum by at most as much per row, for what a map errs by moves the estimate by no more than itself, in chi2.
constexpr double kLinearisationError = 1e-5;
/// Beyond this turn (rad) since its reference a pose gets a new one: rotation vectors are good up to π.
constexpr double kMostTurn = 1.0;

}  // namespace

template <int Dim>
JoinedIndex IncrementalEstimate<Dim>::add_variable(bool is_pose, const Pose<Dim>& value, bool is_anchored) {
  JoinedVariable<Dim>& added = variables_.emplace_back();
  added.is_pose = is_pose;
  added.reference = added.value = value;
  const JoinedIndex v(variables_.size() - 1);
  if (is_anchored) return v;
  added.column = tree_.add_variable(added.dof());
  variable_of_column_.resize(added.column.position() + 1);
  variable_of_column_[added.column] = v;
  free_ += added.dof();
  return v;
}

template <int Dim>
void IncrementalEstimate<Dim>::place(JoinedIndex v, const Pose<Dim>& value) {
  variable(v).reference = variable(v).value = value;
}

template <int Dim>
FactorIndex IncrementalEstimate<Dim>::add_factor(MapFactor<Dim> map) {
  const FactorIndex f(factors_.size());
  for (const JoinedIndex v : map.variables()) {
    if (v != kJoinedWorld) variable(v).factors.push_back(f);
  }
  rows_ += map.rows();
  Factor& added = factors_.emplace_back(Factor{std::move(map), {}, {}, 0});
  added.fit.chi2 = added.map.chi2(variables_);
  chi2_ += added.fit.chi2;
  stale_.push_back(f);
  return f;
}

template <int Dim>
void IncrementalEstimate<Dim>::remove_factor(FactorIndex f) {
  Factor& removed = factor(f);
  for (const JoinedIndex v : removed.map.variables()) {
    if (v != kJoinedWorld) std::erase(variable(v).factors, f);
  }
  rows_ -= removed.map.rows();
  chi2_ -= std::exchange(removed.fit, {}).chi2;
  std::erase(stale_, f);
  if (removed.quadratic) tree_.remove_quadratic(*removed.quadratic);
}

template <int Dim>
Settling IncrementalEstimate<Dim>::settle(std::span<const JoinedIndex> last) {
  std::vector<Variable> last_columns;
  for (const JoinedIndex v : last) {
    if (variable(v).column != kConstant) last_columns.push_back(variable(v).column);
  }
  Settling settling;
  if (looks_ >= factors_.size()) sum_chi2();
  while (!settling.converged && settling.iterations < kMostIterations) {
    linearise_stale();
    settling.eliminated += tree_.update(last_columns);
    ++settling.iterations;
    const double before = chi2_;
    if (!take_step()) break;
    refer_turned();
    settling.converged = stale_.empty() || before - chi2_ <= rounding();
  }
  show_moved();
  settling.moved = take_moved();
  known_ = variables_.size();
  return settling;
}

template <int Dim>
std::optional<Eigen::MatrixXd> KeptEstimate<Dim>::covariance(std::span<const JoinedIndex> of) const {
  std::vector<mapjoin::Variable> columns;
  Eigen::Index size = 0;
  for (const JoinedIndex v : of) {
    if (variables[v].column != kConstant) columns.push_back(variables[v].column);
    size += variables[v].dof();
  }
  const auto of_free = factor.covariance(columns);  // of δ
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

/// Anew, without the rounding of all that was added and taken away.
template <int Dim>
void IncrementalEstimate<Dim>::sum_chi2() {
  chi2_ = 0.0;
  for (const Factor& factor : factors_) chi2_ += factor.fit.chi2;
  looks_ = 0;
}

template <int Dim>
void IncrementalEstimate<Dim>::linearise_stale() {
  for (const FactorIndex f : stale_) {
    Factor& stale = factor(f);
    Quadratic system = stale.map.linearise(variables_);
    if (stale.quadratic) {
      tree_.change_quadratic(*stale.quadratic, std::move(system.H));
    } else {
      stale.quadratic = tree_.add_quadratic(std::move(system));
    }
  }
  stale_.clear();
}

template <int Dim>
double IncrementalEstimate<Dim>::rounding() const {
  return kLinearisationError * static_cast<double>(rows_);
}

template <int Dim>
bool IncrementalEstimate<Dim>::take_step() {
  ++steps_;
  const double before = chi2_;
  std::vector<PoseVector<Dim>> from;
  std::vector<FactorIndex> concerned;
  for (const Variable column : tree_.moved()) {
    const JoinedIndex v = variable_of_column_[column];
    if (v.position() < known_) before_.try_emplace(v, variable(v).value);
    from.push_back(variable(v).step);
    PoseVector<Dim> to = PoseVector<Dim>::Zero();
    to.head(variable(v).dof()) = tree_.solution(column);
    move_to(v, to, concerned);
  }
  look_at(concerned);
  if (chi2_ <= before + rounding()) {
    for (const FactorIndex f : concerned) {
      if (factor(f).fit.error > kLinearisationError * static_cast<double>(factor(f).map.rows())) stale_.push_back(f);
    }
    return true;
  }
  auto was = from.begin();
  for (const Variable column : tree_.moved()) {
    tree_.set_solution(column, was->head(variable(variable_of_column_[column]).dof()));
    move_to(variable_of_column_[column], *was++, concerned);
  }
  look_at(concerned);
  return false;
}

template <int Dim>
void IncrementalEstimate<Dim>::move_to(JoinedIndex v, const PoseVector<Dim>& step, std::vector<FactorIndex>& concerned) {
  variable(v).move_to(step);
  for (const FactorIndex f : variable(v).factors) {
    if (std::exchange(factor(f).met_in, steps_) != steps_) concerned.push_back(f);
  }
}

template <int Dim>
void IncrementalEstimate<Dim>::look_at(const std::vector<FactorIndex>& factors) {
  looks_ += factors.size();
  for (const FactorIndex f : factors) {
    const auto fit = factor(f).map.fit(variables_);
    chi2_ += fit.chi2 - factor(f).fit.chi2;
    factor(f).fit = fit;
  }
}

/// A pose that has turned far gets a new reference; what it concerns is linearised again.
template <int Dim>
void IncrementalEstimate<Dim>::refer_turned() {
  if constexpr (Dim == 3) {
    for (const Variable column : tree_.moved()) {
      JoinedVariable<Dim>& turned = variable(variable_of_column_[column]);
      if (!turned.is_pose || turned.step.template tail<3>().norm() < kMostTurn) continue;
      turned.refer_to_value();
      tree_.set_solution(column, turned.step);
      stale_.insert(stale_.end(), turned.factors.begin(), turned.factors.end());
    }
    std::sort(stale_.begin(), stale_.end());
    stale_.erase(std::unique(stale_.begin(), stale_.end()), stale_.end());
  }
}

template <int Dim>
void IncrementalEstimate<Dim>::show_moved() {
  const auto show = [&](JoinedIndex v) {
    const JoinedVariable<Dim>& is = variable(v);
    shown_.writable(v) = {is.is_pose, is.value, is.step.template tail<kRotationDof<Dim>>(), is.column};
  };
  for (const auto& [v, was] : before_) show(v);
  while (shown_.size() < variables_.size()) show(shown_.push_back({}));
}

/// How far those have gone that are remembered, which are then forgotten.
template <int Dim>
StepSize IncrementalEstimate<Dim>::take_moved() {
  StepSize size;
  for (const auto& [v, was] : before_) {
    const JoinedVariable<Dim>& is = variable(v);
    const PoseVector<Dim> step = local(was, is.value);
    size.metres = std::max(size.metres, step.template head<Dim>().norm());
    if (is.is_pose) size.radians = std::max(size.radians, step.template tail<kRotationDof<Dim>>().norm());
  }
  before_.clear();
  return size;
}

template struct KeptEstimate<2>;
template struct KeptEstimate<3>;
template class IncrementalEstimate<2>;
template class IncrementalEstimate<3>;

}  // namespace mapjoin
