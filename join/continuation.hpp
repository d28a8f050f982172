// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join by continuation from a linear least-squares problem to the whole one (paper's (24), (25), (35)).
//
// In the relative state the rows of the spanning tree give a chi2 that is quadratic in the relations, Q(x_rel); a local map
// contributes the marginal of its tree's rows. (Rows of an edge that leads from target to base are quadratic in the inverse of
// the relation, which has one minimum as well.) N(x_rel) is the rest: closures, features seen again, and the other rows of a
// local map given those of the tree. The objective is Q + s N: at the weight s = 0 it is linear, with one minimum, the composed
// start, wherever a solve begins; at s = 1 it is the join itself.

#include <Eigen/Core>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Reweights the observations of a join along the continuation.
template <int Dim>
class Continuation {
 public:
  /// `join` is the system of `partial` and `gauge`; all three must outlive the continuation. The weight begins at 1.
  Continuation(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge);
  Continuation(const Continuation&) = delete;
  Continuation& operator=(const Continuation&) = delete;

  /// Sets the weight s of N, in [0, 1]. Below 1 `join` refers to reweighted copies, and must not be used once the continuation
  /// is gone.
  void set_weight(double weight);

 private:
  /// A local map, and its copy with the information s W + (1 - s) M, M being the marginal of the tree's rows.
  struct WeightedMap {
    const LocalMap<Dim>* original;
    LocalMap<Dim> weighted;
    std::vector<Eigen::Index> tree_rows{};
    Eigen::MatrixXd quadratic{};  // M, over the tree's rows
  };
  template <typename Observation>
  struct WeightedObservation {
    const Observation* original;
    Observation weighted;
    bool is_quadratic = false;
  };
  void take_tree();

  JoiningSystem<Dim>& join_;
  const PartialMap<Dim>& partial_;
  const Gauge<Dim>& gauge_;
  PartialMap<Dim> weighted_partial_;
  Gauge<Dim> weighted_gauge_;
  std::vector<WeightedObservation<PoseFactor<Dim>>> poses_;        // factors of the partial map, then priors of the gauge
  std::vector<WeightedObservation<FeatureFactor<Dim>>> features_;  // in the same order
  std::vector<WeightedMap> maps_;
};

/// The optimum at one weight of N.
struct PathPoint {
  double weight = 0.0;
  MinimiseResult result;
};

/// Follows the optimum of a join of `partial` and `gauge`, from any start, through s = 0, 1e-6, 1e-5, …, 0.1, with steps in the
/// coordinates of `state`. The join itself, s = 1, remains to be solved.
template <int Dim>
std::vector<PathPoint> follow_path(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge,
                                   JoinedState state, Method method, const std::stop_token& stop = {});

}  // namespace mapjoin
