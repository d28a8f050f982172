// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <mapjoin/localmap/segment_system.hpp>
#include <mapjoin/model/accumulate.hpp>
#include <mapjoin/model/cost.hpp>

namespace mapjoin {
namespace {

template <int Dim>
Eigen::Index border_size(const SegmentView<Dim>& view, const SegmentFreedom& freedom) {
  Eigen::Index size = freedom.base ? kPoseDof<Dim> : 0;
  if (freedom.kept) size += static_cast<Eigen::Index>(view.kept.size()) * kPoseDof<Dim>;
  return size + Dim * std::count(freedom.features.begin(), freedom.features.end(), true);
}

}  // namespace

/// Takes the blocks of an observation of one target into chain, border rows or border.
template <int Dim>
class SegmentSystem<Dim>::Sink {
 public:
  Sink(ChainSystem<Dim>& equations, Slot base, Slot target) : equations_(equations), slots_{base, target} {}

  template <typename Block>
  void hessian(int i, int j, const Block& block) {
    const Slot a = slots_[static_cast<std::size_t>(i)];
    const Slot b = slots_[static_cast<std::size_t>(j)];
    if (!a.is_free() || !b.is_free()) return;
    if (a.entry <= b.entry) {
      add(a.entry, b.entry, block);
    } else {
      add(b.entry, a.entry, block.transpose());
    }
  }
  template <typename Block>
  void rhs(int i, const Block& block) {
    const Slot a = slots_[static_cast<std::size_t>(i)];
    if (a.is_free()) equations_.gradient().segment(a.entry, block.size()) += block;
  }

 private:
  /// The block at row and column, row ≤ column; the chain's entries come first.
  template <typename Block>
  void add(Eigen::Index row, Eigen::Index column, const Block& block) {
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
  std::array<Slot, 2> slots_;
};

template <int Dim>
SegmentSystem<Dim>::SegmentSystem(const SegmentView<Dim>& view, const SegmentFreedom& freedom)
    : view_(&view),
      pose_slots_(view.poses()),
      feature_slots_(view.features.size()),
      equations_(static_cast<Eigen::Index>(view.interior.size()), border_size(view, freedom)) {
  Eigen::Index entry = 0;
  const auto place_pose = [&](PoseIndex pose) {
    pose_slots_[view.place(pose)].entry = entry;
    entry += kDof;
  };
  for (const PoseIndex pose : view.interior) place_pose(pose);
  if (freedom.base) place_pose(view.begin);
  if (freedom.kept) {
    for (const PoseIndex pose : view.kept) place_pose(pose);
  }
  for (const FeatureIndex f : indices(view.features)) {
    if (!freedom.features[f]) continue;
    feature_slots_[f].entry = entry;
    entry += Dim;
  }
  observed_.reserve(view.observations.size());
  for (const auto& observation : view.observations) observed_.push_back(view.place(observation.target));
}

template <int Dim>
template <typename F>
void SegmentSystem<Dim>::for_each_linear(const Values<Dim>& values, F&& f) {
  for (const auto& o : view_->odometry) {
    const PoseIndex base = view_->place(o.base);
    const PoseIndex target = view_->place(o.target);
    f(mapjoin::linearise(o, values.poses[base], values.poses[target]),
      Sink(equations_, pose_slots_[base], pose_slots_[target]));
  }
  for (std::size_t k = 0; k < view_->observations.size(); ++k) {
    const auto& o = view_->observations[k];
    const PoseIndex base = view_->place(o.base);
    f(mapjoin::linearise(o, values.poses[base], values.features[observed_[k]]),
      Sink(equations_, pose_slots_[base], feature_slots_[observed_[k]]));
  }
}

template <int Dim>
double SegmentSystem<Dim>::linearise(const Values<Dim>& values) {
  equations_.set_zero();
  double chi2 = 0.0;
  for_each_linear(values, [&](const auto& linear, Sink sink) { chi2 += accumulate(linear, sink); });
  return chi2;
}

template <int Dim>
void SegmentSystem<Dim>::add_curvature(const Values<Dim>& values) {
  for_each_linear(values, [](const auto& linear, Sink sink) { accumulate_curvature(linear, sink); });
}

template <int Dim>
double SegmentSystem<Dim>::chi2(const Values<Dim>& values) const {
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
void SegmentSystem<Dim>::retract(const Eigen::VectorXd& step, Values<Dim>& values) const {
  for (const PoseIndex p : indices(pose_slots_)) {
    if (!pose_slots_[p].is_free()) continue;
    values.poses[p] = mapjoin::retract<Dim>(values.poses[p], step.segment<kDof>(pose_slots_[p].entry));
  }
  for (const FeatureIndex f : indices(feature_slots_)) {
    if (feature_slots_[f].is_free()) values.features[f] += step.segment<Dim>(feature_slots_[f].entry);
  }
}

template <int Dim>
StepSize SegmentSystem<Dim>::step_size(const Eigen::VectorXd& step) const {
  StepSize size;
  for (const Slot& slot : pose_slots_) {
    if (!slot.is_free()) continue;
    size.metres = std::max(size.metres, step.segment<Dim>(slot.entry).norm());
    size.radians = std::max(size.radians, step.segment<kRotationDof<Dim>>(slot.entry + Dim).norm());
  }
  for (const Slot& slot : feature_slots_) {
    if (slot.is_free()) size.metres = std::max(size.metres, step.segment<Dim>(slot.entry).norm());
  }
  return size;
}

template class SegmentSystem<2>;
template class SegmentSystem<3>;

}  // namespace mapjoin
