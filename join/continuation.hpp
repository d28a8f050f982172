// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join by continuation: between a linear least-squares problem and the whole one (paper's (24), (25), (35)).
//
// In the relative state the rows of the spanning tree are quadratic in the relations: Q(x_rel), of a local map the marginal of
// its tree's rows. (Where the tree leads from target to base, they are so in the relation's inverse: one minimum as well.) The
// rest, closures and features seen again, of a map its other rows given those, is N(x_rel). This is Q + s N: linear at the
// weight s = 0, with one minimum, the composed start, whatever it was begun from; the join itself at s = 1.

#include <Eigen/Core>
#include <mapjoin/join/joined_state.hpp>
#include <mapjoin/join/joining_system.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Weighs the observations of a join.
template <int Dim>
class Continuation {
 public:
  /// `join` is of `partial` and `gauge`; all three must outlive this. Its weight is 1.
  Continuation(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge);
  Continuation(const Continuation&) = delete;
  Continuation& operator=(const Continuation&) = delete;

  /// The weight s of N, in [0, 1]. Below 1, `join` is of copies, and must not be used after this is gone.
  void set_weight(double weight);

 private:
  /// A map or an observation, and its copy of weighted information: s W + (1 - s) of the marginal of the tree's rows.
  struct WeightedMap {
    const LocalMap<Dim>* original;
    LocalMap<Dim> weighted;
    std::vector<Eigen::Index> tree_rows{};
    Eigen::MatrixXd quadratic{};  // over the tree's rows
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
  std::vector<WeightedObservation<PoseFactor<Dim>>> poses_;        // those of the partial map, then those of the gauge
  std::vector<WeightedObservation<FeatureFactor<Dim>>> features_;  // likewise
  std::vector<WeightedMap> maps_;
};

/// The optimum at one weight of N.
struct PathPoint {
  double weight = 0.0;
  MinimiseResult result;
};

/// Leads a join of `partial` and `gauge`, from whatever start, to the optimum at s = 0, 1e-6, 1e-5, …, 0.1, one after the
/// other, with steps in the coordinates of `state`. The join itself, s = 1, is left to be solved.
template <int Dim>
std::vector<PathPoint> follow_path(JoiningSystem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge,
                                   JoinedState state, Method method, const std::stop_token& stop = {});

}  // namespace mapjoin
