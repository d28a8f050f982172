// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/live_segment.hpp>
#include <mapjoin/solve/pivot.hpp>
#include <utility>

namespace mapjoin {
namespace {

template <int Dim>
SegmentFreedom all_free(const Segment<Dim>& segment) {
  return {true, true, std::vector<bool>(segment.features.size(), true)};
}

}  // namespace

template <int Dim>
LiveSegment<Dim>::LiveSegment(const Segment<Dim>& segment, const std::vector<bool>& is_private,
                              const NormalEquations& equations, std::span<const Index> variables, Eigen::Index own_offset,
                              State<Dim> values)
    : segment_(&segment),
      system_(segment, all_free(segment)),
      own_offset_(own_offset),
      values_(std::move(values)),
      candidate_(values_),
      eliminated_(0, 0) {
  Eigen::Index next_own = own_offset_ + system_.equations().chain_length() * kPoseDof<Dim>;
  Eigen::Index entry = 0;
  std::size_t slot = 0;
  const auto add = [&](int dof, bool is_own) {
    BorderVariable variable{entry, -1, dof, is_own};
    if (is_own) {
      variable.whole_entry = next_own;
      next_own += dof;
    } else {
      const Index joined = variables[slot++];
      if (joined != kConstant) variable.whole_entry = equations.offset(joined);
    }
    border_.push_back(variable);
    for (int i = 0; i < dof; ++i) (is_own ? own_rows_ : shared_rows_).push_back(entry + i);
    entry += dof;
  };
  for (std::size_t p = 0; p < 1 + segment.kept.size(); ++p) add(kPoseDof<Dim>, false);
  for (const Index feature : segment.features) {
    is_own_feature_.push_back(is_private[static_cast<std::size_t>(feature)]);
    add(Dim, is_own_feature_.back());
  }
}

template <int Dim>
Eigen::Index LiveSegment<Dim>::own_size(const Segment<Dim>& segment, const std::vector<bool>& is_private) {
  const auto own_features = std::count_if(segment.features.begin(), segment.features.end(),
                                          [&](Index feature) { return is_private[static_cast<std::size_t>(feature)]; });
  return static_cast<Eigen::Index>(segment.interior.size()) * kPoseDof<Dim> + own_features * Dim;
}

template <int Dim>
Eigen::VectorXd LiveSegment<Dim>::gathered(const Eigen::VectorXd& whole) const {
  const Eigen::Index chain = system_.equations().chain_length() * kPoseDof<Dim>;
  Eigen::VectorXd step = Eigen::VectorXd::Zero(system_.equations().size());
  step.head(chain) = whole.segment(own_offset_, chain);
  for (const auto& v : border_) {
    if (v.whole_entry >= 0) step.segment(chain + v.entry, v.dof) = whole.segment(v.whole_entry, v.dof);
  }
  return step;
}

template <int Dim>
void LiveSegment<Dim>::scatter(const Eigen::VectorXd& own, Eigen::VectorXd& whole) const {
  const Eigen::Index chain = system_.equations().chain_length() * kPoseDof<Dim>;
  whole.segment(own_offset_, chain) += own.head(chain);
  for (const auto& v : border_) {
    if (v.whole_entry >= 0) whole.segment(v.whole_entry, v.dof) += own.segment(chain + v.entry, v.dof);
  }
}

template <int Dim>
bool LiveSegment<Dim>::eliminate(double damping) {
  eliminated_ = system_.equations();
  if (damping > 0.0) eliminated_.damp(damping);
  if (!eliminated_.eliminate_chain()) return false;
  const Eigen::MatrixXd C = eliminated_.border().template selfadjointView<Eigen::Upper>();
  reduced_ = C(shared_rows_, shared_rows_);
  if (own_rows_.empty()) {
    reduce_gradient();
    return true;
  }
  const Eigen::MatrixXd C_os = C(own_rows_, shared_rows_);
  own_factor_.compute(C(own_rows_, own_rows_));
  if (own_factor_.info() != Eigen::Success) return false;
  for (std::size_t k = 0; k < own_rows_.size(); ++k) {
    const auto i = static_cast<Eigen::Index>(k);
    const double diagonal = system_.equations().border()(own_rows_[k], own_rows_[k]);
    if (has_lost_digits(own_factor_.matrixLLT()(i, i), diagonal)) return false;
  }
  own_gain_ = own_factor_.solve(C_os);
  reduced_.noalias() -= C_os.transpose() * own_gain_;
  reduce_gradient();
  return true;
}

template <int Dim>
void LiveSegment<Dim>::eliminate_gradient() {
  eliminated_.eliminate_gradient(system_.equations().gradient());
  reduce_gradient();
}

template <int Dim>
void LiveSegment<Dim>::reduce_gradient() {
  const Eigen::VectorXd g = eliminated_.gradient().tail(eliminated_.border_size());
  reduced_gradient_ = g(shared_rows_);
  if (own_rows_.empty()) return;
  const Eigen::VectorXd g_own = g(own_rows_);
  own_solution_ = own_factor_.solve(g_own);
  reduced_gradient_.noalias() -= own_gain_.transpose() * g_own;
}

template <int Dim>
void LiveSegment<Dim>::add_reduced(NormalEquations::Sink sink) const {
  int j = 0;
  Eigen::Index column = 0;
  for (const auto& b : border_) {
    if (b.is_own) continue;
    int i = 0;
    Eigen::Index row = 0;
    for (const auto& a : border_) {
      if (a.is_own) continue;
      sink.hessian(i, j, reduced_.block(row, column, a.dof, b.dof));
      row += a.dof;
      if (++i > j) break;
    }
    column += b.dof;
    ++j;
  }
  add_reduced_gradient(sink);
}

template <int Dim>
void LiveSegment<Dim>::add_reduced_gradient(NormalEquations::Sink sink) const {
  int j = 0;
  Eigen::Index row = 0;
  for (const auto& b : border_) {
    if (b.is_own) continue;
    sink.rhs(j++, reduced_gradient_.segment(row, b.dof));
    row += b.dof;
  }
}

template <int Dim>
void LiveSegment<Dim>::back_substitute(Eigen::VectorXd& whole) const {
  const Eigen::Index chain = eliminated_.chain_length() * kPoseDof<Dim>;
  Eigen::VectorXd border = gathered(whole).tail(eliminated_.border_size());
  if (!own_rows_.empty()) border(own_rows_) = own_solution_ - own_gain_ * border(shared_rows_);
  whole.segment(own_offset_, chain) = eliminated_.chain_step(border);
  for (const auto& v : border_) {
    if (v.is_own) whole.segment(v.whole_entry, v.dof) = border.segment(v.entry, v.dof);
  }
}

template <int Dim>
OwnGivenShared<Dim> LiveSegment<Dim>::own_given_shared() const {
  OwnGivenShared<Dim> own;
  own.poses = segment_->interior;
  for (std::size_t f = 0; f < segment_->features.size(); ++f) {
    if (is_own_feature_[f]) own.features.push_back(segment_->features[f]);
  }
  own.chain = ChainGivenBorder<Dim>(eliminated_);
  const Eigen::MatrixXd& M = own.chain.gain();
  const auto own_size = static_cast<Eigen::Index>(own_rows_.size());
  own.pose_gain = M(Eigen::all, own_rows_);
  own.gain.resize(M.rows() + own_size, static_cast<Eigen::Index>(shared_rows_.size()));
  own.gain.topRows(M.rows()) = M(Eigen::all, shared_rows_);
  if (own_size == 0) return own;
  own.gain.topRows(M.rows()).noalias() -= own.pose_gain * own_gain_;
  own.gain.bottomRows(own_size) = -own_gain_;
  own.feature_covariance = own_factor_.solve(Eigen::MatrixXd::Identity(own_size, own_size));
  return own;
}

template <int Dim>
double LiveSegment<Dim>::try_step(const Eigen::VectorXd& whole) {
  candidate_ = values_;
  system_.retract(gathered(whole), candidate_);
  return system_.chi2(candidate_);
}

template <int Dim>
void LiveSegment<Dim>::add_step_size(const Eigen::VectorXd& whole, StepSize& size) const {
  const StepSize own = system_.step_size(gathered(whole));
  size.metres = std::max(size.metres, own.metres);
  size.radians = std::max(size.radians, own.radians);
}

template <int Dim>
void LiveSegment<Dim>::write_own(State<Dim>& state) const {
  for (const Index pose : segment_->interior) {
    state.poses[static_cast<std::size_t>(pose)] = values_.poses[static_cast<std::size_t>(pose - segment_->begin)];
  }
  for (std::size_t f = 0; f < segment_->features.size(); ++f) {
    if (is_own_feature_[f]) state.features[static_cast<std::size_t>(segment_->features[f])] = values_.features[f];
  }
}

template class LiveSegment<2>;
template class LiveSegment<3>;

}  // namespace mapjoin
