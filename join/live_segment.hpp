// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A segment within the joining system: its own variables, interior poses and private features, are eliminated at the current
// estimate.

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <mapjoin/join/joint_system.hpp>
#include <mapjoin/join/own_given_shared.hpp>
#include <mapjoin/localmap/segment_system.hpp>
#include <vector>

namespace mapjoin {

/// Steps and gradients "of the whole" have the joined state's entries first; this segment's own stand from `own_offset` on.
template <int Dim>
class LiveSegment {
 public:
  LiveSegment(const Segment<Dim>& segment, const std::vector<bool>& is_private, const NormalEquations& equations,
              std::span<const Index> variables, Eigen::Index own_offset, State<Dim> values);

  /// How many entries of a step belong to a segment alone.
  static Eigen::Index own_size(const Segment<Dim>& segment, const std::vector<bool>& is_private);

  double linearise() { return system_.linearise(values_); }
  void add_gradient(Eigen::VectorXd& whole) const { scatter(system_.equations().gradient(), whole); }
  void add_diagonal(Eigen::VectorXd& whole) const { scatter(system_.equations().diagonal(), whole); }
  double curvature(const Eigen::VectorXd& whole) const { return system_.equations().curvature(gathered(whole)); }

  /// Eliminates what is its own from H + damping·diag(H); false where that is singular.
  bool eliminate(double damping);
  /// By the last elimination, of the gradient at the estimate.
  void eliminate_gradient();
  /// Adds what is left of H and g to the normal equations,
  void add_reduced(NormalEquations::Sink sink) const;
  /// or of g only.
  void add_reduced_gradient(NormalEquations::Sink sink) const;
  /// Its own part of the solution, given the joined state's.
  void back_substitute(Eigen::VectorXd& whole) const;

  /// What is its own as a Gaussian given the rest, after eliminate().
  OwnGivenShared<Dim> own_given_shared() const;

  double try_step(const Eigen::VectorXd& whole);
  void accept() { values_ = candidate_; }
  void add_step_size(const Eigen::VectorXd& whole, StepSize& size) const;
  void write_own(State<Dim>& state) const;

 private:
  /// A border variable: its entry in the border, and where it stands in the whole, or -1 where it is held.
  struct BorderVariable {
    Eigen::Index entry;
    Eigen::Index whole_entry;
    int dof;
    bool is_own;
  };
  /// From the order of the whole to that of the segment's equations, and back.
  Eigen::VectorXd gathered(const Eigen::VectorXd& whole) const;
  void scatter(const Eigen::VectorXd& own, Eigen::VectorXd& whole) const;

  void reduce_gradient();

  const Segment<Dim>* segment_;
  SegmentSystem<Dim> system_;
  Eigen::Index own_offset_;
  std::vector<BorderVariable> border_;
  std::vector<Eigen::Index> own_rows_;     // border entries of private features
  std::vector<Eigen::Index> shared_rows_;  // the others
  std::vector<bool> is_own_feature_;       // per feature of the segment

  State<Dim> values_;
  State<Dim> candidate_;
  ChainSystem<Dim> eliminated_;
  Eigen::LLT<Eigen::MatrixXd> own_factor_;
  Eigen::MatrixXd own_gain_;      // C_oo⁻¹ C_os
  Eigen::VectorXd own_solution_;  // C_oo⁻¹ g_o
  Eigen::MatrixXd reduced_;       // C_ss - C_so C_oo⁻¹ C_os
  Eigen::VectorXd reduced_gradient_;
};

}  // namespace mapjoin
