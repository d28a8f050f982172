// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <mapjoin/localmap/segment_problem.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <utility>

namespace mapjoin {
template <int Dim>
SegmentProblem<Dim>::SegmentProblem(const SegmentView<Dim>& view, const SegmentFreedom& freedom, Values<Dim> start)
    : system_(view, freedom), factored_(0, 0), estimate_(std::move(start)), candidate_(estimate_) {}

template <int Dim>
double SegmentProblem<Dim>::linearise() {
  is_eliminated_ = false;
  return system_.linearise(estimate_);
}

template <int Dim>
std::optional<Variable> SegmentProblem<Dim>::factorise(double damping) {
  is_eliminated_ = true;
  const Eigen::VectorXd scale = system_.equations().diagonal().tail(system_.equations().border_size());
  factored_ = system_.equations();
  if (damping > 0.0) factored_.damp(damping);
  if (!factored_.eliminate_chain()) return 0;
  const Eigen::LLT<Eigen::MatrixXd, Eigen::Upper> llt(factored_.border());
  border_factor_ = llt.matrixL();
  if (border_factor_.size() == 0) return std::nullopt;
  if (llt.info() != Eigen::Success) return 0;
  for (Eigen::Index i = 0; i < scale.size(); ++i) {
    if (has_lost_digits(border_factor_(i, i), scale[i])) return 0;
  }
  return std::nullopt;
}

template <int Dim>
Eigen::VectorXd SegmentProblem<Dim>::solve() {
  if (!is_eliminated_) factored_.eliminate_gradient(system_.equations().gradient());
  is_eliminated_ = true;
  const auto L = std::as_const(border_factor_).triangularView<Eigen::Lower>();
  Eigen::VectorXd border_step = factored_.gradient().tail(factored_.border_size());
  if (border_step.size() > 0) {
    L.solveInPlace(border_step);
    L.transpose().solveInPlace(border_step);
  }
  Eigen::VectorXd step(factored_.size());
  step << factored_.chain_step(border_step), border_step;
  return step;
}

template <int Dim>
double SegmentProblem<Dim>::try_step(const Eigen::VectorXd& step) {
  candidate_ = estimate_;
  system_.retract(step, candidate_);
  return system_.chi2(candidate_);
}

template <int Dim>
std::optional<Eigen::MatrixXd> SegmentProblem<Dim>::marginal_information() {
  linearise();
  if (factorise(0.0)) return std::nullopt;
  return Eigen::MatrixXd(factored_.border().template selfadjointView<Eigen::Upper>());
}

template <int Dim>
Values<Dim> composed_start(const SegmentView<Dim>& view) {
  Values<Dim> start;
  start.poses.resize(view.poses());
  start.features.resize(view.features.size());
  for (const auto& o : view.odometry) {
    const PoseIndex base = view.place(o.base);
    const PoseIndex target = view.place(o.target);
    if (target > base) {
      start.poses[target] = compose(start.poses[base], o.measured);
    } else {
      start.poses[base] = compose(start.poses[target], inverse(o.measured));
    }
  }
  Table<FeatureIndex, bool> seen(view.features.size(), false);
  for (const auto& o : view.observations) {
    const FeatureIndex f = view.place(o.target);
    if (seen[f]) continue;
    seen[f] = true;
    start.features[f] = transform(start.poses[view.place(o.base)], o.measured);
  }
  return start;
}

template class SegmentProblem<2>;
template class SegmentProblem<3>;
template Values<2> composed_start(const SegmentView<2>&);
template Values<3> composed_start(const SegmentView<3>&);

}  // namespace mapjoin
