// SPDX-License-Identifier: BSD-3-Clause
#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <mapjoin/localmap/segment_problem.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>
#include <mapjoin/solve/sparse_solver.hpp>
#include <utility>

namespace mapjoin {

/// Adds the blocks of an observation of one target to chain, border rows or border.
template <int Dim>
class SegmentProblem<Dim>::Sink {
 public:
  Sink(ChainSystem<Dim>& equations, Entry base, Entry target) : equations_(equations), entries_{base, target} {}

  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    const Entry a = entries_[static_cast<std::size_t>(i)];
    const Entry b = entries_[static_cast<std::size_t>(j)];
    if (a == kStill || b == kStill) return;
    if (a <= b) {
      add(a, b, block);
    } else {
      add(b, a, block.transpose());
    }
  }
  template <typename Block>
  void rhs(int i, const Block& block) {
    const Entry a = entries_[static_cast<std::size_t>(i)];
    if (a != kStill) equations_.gradient().segment(a, block.size()) += block;
  }

 private:
  /// Adds the block at row and column, row ≤ column; the chain's entries come first.
  template <typename Block>
  void add(Entry row, Entry column, const Block& block) {
    const Eigen::Index chain = equations_.chain_length() * kDof;
    if (row >= chain) {
      equations_.border().block(row - chain, column - chain, block.rows(), block.cols()) += block;
      return;
    }
    if constexpr (Block::RowsAtCompileTime == kDof) {  // the chain has poses only
      if (column >= chain) {
        equations_.border_rows(row / kDof).middleCols(column - chain, block.cols()) += block;
        return;
      }
    }
    if constexpr (Block::RowsAtCompileTime == kDof && Block::ColsAtCompileTime == kDof) {
      (row == column ? equations_.diagonal_block(row / kDof) : equations_.coupling(row / kDof)) += block;
    }
  }

  ChainSystem<Dim>& equations_;
  std::array<Entry, 2> entries_;
};

template <int Dim>
SegmentProblem<Dim>::SegmentProblem(const SegmentView<Dim>& view, const SegmentFreedom& freedom, Values<Dim> start)
    : view_(&view),
      pose_entries_(view.poses(), kStill),
      feature_entries_(view.features.size(), kStill),
      equations_(0, 0),
      factored_(0, 0),
      estimate_(std::move(start)),
      candidate_(estimate_) {
  Entry entry = 0;
  for (const PoseIndex pose : view.interior) pose_entries_[view.place(pose)] = std::exchange(entry, entry + kDof);
  if (freedom.kept) {
    for (const PoseIndex pose : view.kept) pose_entries_[view.place(pose)] = std::exchange(entry, entry + kDof);
  }
  for (const FeatureIndex f : indices(view.features)) {
    if (freedom.features[f]) feature_entries_[f] = std::exchange(entry, entry + Dim);
  }
  const auto chain = static_cast<Eigen::Index>(view.interior.size());
  equations_ = ChainSystem<Dim>(chain, entry - chain * kDof);
  observed_.reserve(view.observations.size());
  for (const auto& observation : view.observations) observed_.push_back(view.place(observation.target));
}

template <int Dim>
template <typename F>
double SegmentProblem<Dim>::sum_linear(F&& f) {
  double sum = 0.0;
  for (const auto& o : view_->odometry) {
    const PoseIndex base = view_->place(o.base);
    const PoseIndex target = view_->place(o.target);
    sum += f(mapjoin::linearise(o, estimate_.poses[base], estimate_.poses[target]),
             Sink(equations_, pose_entries_[base], pose_entries_[target]));
  }
  for (std::size_t k = 0; k < view_->observations.size(); ++k) {
    const auto& o = view_->observations[k];
    const PoseIndex base = view_->place(o.base);
    sum += f(mapjoin::linearise(o, estimate_.poses[base], estimate_.features[observed_[k]]),
             Sink(equations_, pose_entries_[base], feature_entries_[observed_[k]]));
  }
  return sum;
}

template <int Dim>
double SegmentProblem<Dim>::linearise() {
  is_eliminated_ = false;
  equations_.set_zero();
  return sum_linear([](const auto& linear, Sink sink) { return accumulate(linear, sink); });
}

template <int Dim>
void SegmentProblem<Dim>::add_curvature() {
  sum_linear([](const auto& linear, Sink sink) {
    accumulate_curvature(linear, sink);
    return 0.0;
  });
}

template <int Dim>
double SegmentProblem<Dim>::chi2(const Values<Dim>& values) const {
  double chi2 = 0.0;
  for (const auto& o : view_->odometry) {
    chi2 += cost(o, values.poses[view_->place(o.base)], values.poses[view_->place(o.target)]);
  }
  for (std::size_t k = 0; k < view_->observations.size(); ++k) {
    const auto& o = view_->observations[k];
    chi2 += cost(o, values.poses[view_->place(o.base)], values.features[observed_[k]]);
  }
  return chi2;
}

template <int Dim>
std::optional<Variable> SegmentProblem<Dim>::factorise(double damping) {
  is_eliminated_ = true;
  const Eigen::VectorXd scale = equations_.diagonal().tail(equations_.border_size());
  factored_ = equations_;
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
  if (!is_eliminated_) factored_.eliminate_gradient(gradient());
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
StepSize SegmentProblem<Dim>::step_size(const Eigen::VectorXd& step) const {
  StepSize size;
  for (const Entry entry : pose_entries_) {
    if (entry == kStill) continue;
    size.metres = std::max(size.metres, step.segment<Dim>(entry).norm());
    size.radians = std::max(size.radians, step.segment<kRotationDof<Dim>>(entry + Dim).norm());
  }
  for (const Entry entry : feature_entries_) {
    if (entry != kStill) size.metres = std::max(size.metres, step.segment<Dim>(entry).norm());
  }
  return size;
}

template <int Dim>
Values<Dim> SegmentProblem<Dim>::retracted(const Eigen::VectorXd& step) const {
  Values<Dim> moved = estimate_;
  for (const PoseIndex p : indices(pose_entries_)) {
    if (pose_entries_[p] != kStill) moved.poses[p] = retract<Dim>(moved.poses[p], step.segment<kDof>(pose_entries_[p]));
  }
  for (const FeatureIndex f : indices(feature_entries_)) {
    if (feature_entries_[f] != kStill) moved.features[f] += step.segment<Dim>(feature_entries_[f]);
  }
  return moved;
}

template <int Dim>
double SegmentProblem<Dim>::try_step(const Eigen::VectorXd& step) {
  candidate_ = retracted(step);
  return chi2(candidate_);
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
