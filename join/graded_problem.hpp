// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join between a linear least-squares problem and the whole one (paper's (24), (25), (35)).
//
// In the relative state the rows of the spanning tree are quadratic in the relations: Q(x_rel), of a local map the marginal of
// its tree's rows. The rest, closures and features seen again, of a map its other rows given those, is N(x_rel). This is Q + s
// N: linear at s = 0, with one minimum, the composed start, whatever it was begun from; the join itself at s = 1.

#include <Eigen/Core>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/world.hpp>
#include <vector>

namespace mapjoin {

template <int Dim>
class GradedProblem {
 public:
  /// Copies the observations and maps of the piece, which may go afterwards.
  GradedProblem(const Piece<Dim>& piece, const Gauge<Dim>& gauge);
  GradedProblem(const GradedProblem&) = delete;
  GradedProblem& operator=(const GradedProblem&) = delete;

  /// Weighs N by s in [0, 1].
  void set_share(double share);
  JoinProblem<Dim>& join() { return join_; }

 private:
  /// A map with its W as it was, and the marginal of the tree's rows in it.
  struct GradedMap {
    LocalMap<Dim> map;
    Eigen::MatrixXd whole;
    Eigen::MatrixXd quadratic;  // of the size of W
  };
  template <typename Observation>
  struct GradedObservation {
    Observation observation;
    decltype(Observation::information) whole;
    bool is_quadratic = false;
  };
  struct Copies {
    Piece<Dim> piece;
    Gauge<Dim> gauge;
    std::vector<GradedObservation<PoseObservation<Dim>>> poses;  // those of the piece, then those of the gauge
    std::vector<GradedObservation<FeatureObservation<Dim>>> features;
    std::vector<GradedMap> maps;

    Copies(const Piece<Dim>& original, const Gauge<Dim>& held);
  };
  void take_tree();

  Copies copies_;
  JoinProblem<Dim> join_;
};

/// The optimum at one share of N.
struct PathPoint {
  double share = 0.0;
  MinimiseResult result;
};

/// Leads the piece to the join's optimum along s = 0, 1e-6, 1e-5, …, 0.1, whatever its state was: the start is forgotten at s =
/// 0, by construction. What is left is the join itself, s = 1.
template <int Dim>
std::vector<PathPoint> lead_gradually(const Gauge<Dim>& gauge, JoinedState state, const MinimiseOptions& options,
                                      const std::stop_token& stop, Piece<Dim>& piece);

}  // namespace mapjoin
