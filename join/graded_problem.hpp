// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join between a linear least-squares problem and the whole one (paper's (24), (25), (35)).
//
// In the relative state the rows of the spanning tree are quadratic in the relations: Q(x_rel), of a local map the marginal of
// its tree's rows. (Where the tree leads from target to base, they are so in the relation's inverse: one minimum as well.) The
// rest, closures and features seen again, of a map its other rows given those, is N(x_rel). This is Q + s N: linear at s = 0,
// with one minimum, the composed start, whatever it was begun from; the join itself at s = 1.

#include <Eigen/Core>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/world.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Weighs the observations of a join problem.
template <int Dim>
class GradedProblem {
 public:
  /// `join` is of `piece` and `gauge`; all three must outlive this. Its share is 1.
  GradedProblem(JoinProblem<Dim>& join, const Piece<Dim>& piece, const Gauge<Dim>& gauge);
  GradedProblem(const GradedProblem&) = delete;
  GradedProblem& operator=(const GradedProblem&) = delete;

  /// Weighs N by s in [0, 1]. Below 1, `join` is of copies, and must not be used after this is gone.
  void set_share(double share);

 private:
  /// A map of weighted information: s W + (1 - s) of the marginal of the tree's rows.
  struct GradedMap {
    const LocalMap<Dim>* whole;
    LocalMap<Dim> weighted;
    std::vector<Eigen::Index> tree_rows{};
    Eigen::MatrixXd quadratic{};  // over the tree's rows
  };
  template <typename Observation>
  struct GradedObservation {
    const Observation* whole;
    Observation weighted;
    bool is_quadratic = false;
  };
  void take_tree();

  JoinProblem<Dim>& join_;
  const Piece<Dim>& piece_;
  const Gauge<Dim>& gauge_;
  Piece<Dim> weighted_piece_;
  Gauge<Dim> weighted_gauge_;
  std::vector<GradedObservation<PoseObservation<Dim>>> poses_;        // those of the piece, then those of the gauge
  std::vector<GradedObservation<FeatureObservation<Dim>>> features_;  // likewise
  std::vector<GradedMap> maps_;
};

/// The optimum at one share of N.
struct PathPoint {
  double share = 0.0;
  MinimiseResult result;
};

/// Leads the estimate of a join problem of `piece` and `gauge` to the join's optimum along s = 0, 1e-6, 1e-5, …, 0.1, whatever
/// it was: the start is forgotten at s = 0, by construction. What is left is the join itself, s = 1.
template <int Dim>
std::vector<PathPoint> lead_gradually(JoinProblem<Dim>& join, const Piece<Dim>& piece, const Gauge<Dim>& gauge,
                                      JoinedState state, const MinimiseOptions& options, const std::stop_token& stop = {});

}  // namespace mapjoin
