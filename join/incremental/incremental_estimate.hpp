// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A joined state that is kept at the optimum of the maps it is made of, while maps and variables are added.

#include <map>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <span>
#include <vector>

namespace mapjoin {

/// How the estimate came to its optimum.
struct Settling {
  bool converged = false;
  int iterations = 0;
  std::size_t eliminated = 0;  ///< Variables, over all iterations.
  StepSize moved;              ///< The most that a variable has moved that was there before.
};

/// Gauss-Newton, with a map linearised again only where its linearisation errs by more than 0.3 % of a standard deviation
/// (rms). A step that would raise chi2 is not taken: the estimate then has not converged, and wants a join of all maps.
template <int Dim>
class IncrementalEstimate {
 public:
  /// Variables are numbered from 0. One that is anchored stays where it is.
  JoinedIndex add_variable(bool is_pose, const Pose<Dim>& value, bool is_anchored);
  /// Puts a variable of which no map is there yet elsewhere.
  void place(JoinedIndex variable, const Pose<Dim>& value);
  void add_factor(MapFactor<Dim> factor);

  /// To the optimum; `last` are the variables that the next maps will probably touch.
  Settling settle(std::span<const JoinedIndex> last);

  const JoinedVariables<Dim>& variables() const { return variables_; }
  const JoinedVariable<Dim>& variable(JoinedIndex v) const { return variables_[v]; }
  /// Of the step of a variable at its value, as of the last settling; dof() rows, zero where it is anchored, nothing where it
  /// may not be determined (see FrontTree).
  std::optional<Eigen::MatrixXd> covariance(JoinedIndex variable) const;
  double chi2() const { return chi2_; }
  /// Measured rows less free entries.
  std::int64_t dof() const { return rows_ - free_; }

 private:
  struct Factor {
    MapFactor<Dim> map;
    std::optional<FrontTree::QuadraticIndex> quadratic;  // of the tree, once it is linearised
    typename MapFactor<Dim>::Fit fit;
    std::size_t met_in = 0;  // the step that looked at it last
  };
  JoinedVariable<Dim>& variable(JoinedIndex v) { return variables_[v]; }
  Factor& factor(FactorIndex f) { return factors_[f]; }
  void sum_chi2();
  void linearise_stale();
  /// Moves the variables to where the tree has them; false where chi2 would rise, all then staying where they are.
  bool take_step();
  /// What chi2 may be off by where every linearisation errs by as much as it may.
  double rounding() const;
  void move_to(JoinedIndex v, const PoseVector<Dim>& step, std::vector<FactorIndex>& concerned);
  /// Brings chi2 up to date with what these factors say now.
  void look_at(const std::vector<FactorIndex>& factors);
  StepSize take_moved();
  void refer_turned();

  JoinedVariables<Dim> variables_;
  Table<Variable, JoinedIndex> variable_of_column_;
  Table<FactorIndex, Factor> factors_;
  std::vector<FactorIndex> stale_;  // factors to be linearised
  FrontTree tree_;
  double chi2_ = 0.0;
  std::int64_t rows_ = 0;
  std::int64_t free_ = 0;
  std::size_t steps_ = 0;
  std::size_t known_ = 0;                    // variables that were there before this settling
  std::map<JoinedIndex, Pose<Dim>> before_;  // where those were that have moved
};

}  // namespace mapjoin
