// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// The join by continuation: between a linear least-squares problem and the whole one (paper's (24), (25), (35)).
//
// In the relative state the rows of the spanning tree are quadratic in the relations: Q(x_rel), of a local map the marginal of
// its tree's rows. (Where the tree leads from target to base, they are so in the relation's inverse: one minimum as well.) The
// rest, closures and features seen again, of a map its other rows given those, is N(x_rel). This is Q + s N: linear at the
// weight s = 0, with one minimum, the composed start, whatever it was begun from; the join itself at s = 1.

#include <Eigen/Core>
#include <mapjoin/join/align/gauge.hpp>
#include <mapjoin/join/join_problem.hpp>
#include <mapjoin/join/run.hpp>
#include <mapjoin/join/submap_graph.hpp>
#include <stop_token>
#include <vector>

namespace mapjoin {

/// Weighs the observations of a join problem.
template <int Dim>
class Continuation {
 public:
  /// `join` is of `partial map` and `gauge`; all three must outlive this. Its weight is 1.
  Continuation(JoinProblem<Dim>& join, const PartialMap<Dim>& partial, const Gauge<Dim>& gauge);
  Continuation(const Continuation&) = delete;
  Continuation& operator=(const Continuation&) = delete;

  /// The weight s of N, in [0, 1]. Below 1, `join` is of copies, and must not be used after this is gone.
  void set_weight(double weight);

 private:
  /// A map or an observation, and its copy of weighted information: s W + (1 - s) of the marginal of the tree's rows.
  struct WeightedMap {
    const LocalMap<Dim>* joined_map;
    LocalMap<Dim> weighted;
    std::vector<Eigen::Index> tree_rows{};
    Eigen::MatrixXd quadratic{};  // over the tree's rows
  };
  template <typename Observation>
  struct WeightedObservation {
    const Observation* joined_map;
    Observation weighted;
    bool is_quadratic = false;
  };
  void take_tree();

  JoinProblem<Dim>& join_;
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

/// The result of a run whose join was begun at the end of a path.
template <int Dim>
struct ContinuedResult : RunResult<Dim> {
  std::vector<PathPoint> path;  ///< At s = 0, 1e-6, 1e-5, …, 0.1, solved one after the other; the join itself is s = 1.

  int path_iterations() const;
};

/// The composed start of all that a submap graph joins, with the first pose at `origin` where the World says nothing.
template <int Dim>
PartialMap<Dim> composed_start(const SubmapGraph<Dim>& graph, const Pose<Dim>& origin);

/// As run() and run_from_maps(), by the batch schedule along a path to its start. With splits of one pose it is full SLAM.
template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>& log, const RunOptions& options, const std::stop_token& stop = {});
template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const Log<Dim>& log, const Split& split, std::vector<LocalMap<Dim>> maps,
                                             const RunOptions& options, const std::stop_token& stop = {});
template <int Dim>
Expected<ContinuedResult<Dim>> run_continued(const SubmapSet<Dim>& set, const RunOptions& options,
                                             const std::stop_token& stop = {});

}  // namespace mapjoin
