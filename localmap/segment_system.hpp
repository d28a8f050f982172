// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The normal equations of one segment: its interior poses are the chain, everything else that is free the dense border.

#include <Eigen/Core>
#include <mapjoin/localmap/chain_system.hpp>
#include <mapjoin/localmap/segment_view.hpp>
#include <mapjoin/model/values.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <vector>

namespace mapjoin {

/// What may move besides the interior poses. The border is laid out as: base, kept poses, features (those that are free).
struct SegmentFreedom {
  bool base = false;
  bool kept = true;
  Table<FeatureIndex, bool> features;  ///< By place in the segment.
};

/// Values of the segment are a State of its own: poses begin..end and its features, by their places in the segment.
template <int Dim>
class SegmentSystem {
 public:
  static constexpr int kDof = kPoseDof<Dim>;

  /// `segment` must outlive the system.
  SegmentSystem(const SegmentView<Dim>& view, const SegmentFreedom& freedom);

  /// Makes the normal equations at `values`; returns chi2 there.
  double linearise(const Values<Dim>& values);
  /// Makes H, after linearise() there, that of full Newton.
  void add_curvature(const Values<Dim>& values);
  double chi2(const Values<Dim>& values) const;

  ChainSystem<Dim>& equations() { return equations_; }
  const ChainSystem<Dim>& equations() const { return equations_; }

  StepSize step_size(const Eigen::VectorXd& step) const;
  /// `values` moved by a step of chain and border.
  void retract(const Eigen::VectorXd& step, Values<Dim>& values) const;

 private:
  /// Where a variable stands: its entry in the step (chain first), or nowhere.
  struct Slot {
    Eigen::Index entry = -1;
    bool is_free() const { return entry >= 0; }
  };
  class Sink;
  /// f(observation linearised at `values`, sink) for every observation of the segment.
  template <typename F>
  void for_each_linear(const Values<Dim>& values, F&& f);

  const SegmentView<Dim>* view_;
  Table<PoseIndex, Slot> pose_slots_;
  Table<FeatureIndex, Slot> feature_slots_;
  std::vector<FeatureIndex> observed_;  ///< Per observation, the place of its feature.
  ChainSystem<Dim> equations_;
};

}  // namespace mapjoin
