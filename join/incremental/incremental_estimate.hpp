// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A joined state that is kept at the optimum of the maps it is made of, while maps and variables are added.

#include <map>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/join/incremental/shared_table.hpp>
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

/// The estimate as a settling left it. It never changes, so any thread may read it.
template <int Dim>
struct KeptEstimate {
  struct Variable {
    bool is_pose = true;
    Pose<Dim> value;                                         ///< Of a feature the translation.
    RotationVector<Dim> turn = RotationVector<Dim>::Zero();  ///< Of a pose, since the reference of the linear system.
    mapjoin::Variable column = kConstant;                    ///< Of the linear system; kConstant where it is anchored.

    int dof() const { return is_pose ? kPoseDof<Dim> : Dim; }
  };

  /// The joint marginal covariance of the steps of different variables at their values, a row for each entry: zero where one is
  /// anchored, nothing where one may not be determined (see FrontFactor).
  std::optional<Eigen::MatrixXd> covariance(std::span<const JoinedIndex> of) const;

  SharedTable<JoinedIndex, Variable> variables;
  FrontFactor factor;
  double chi2 = 0.0;
  std::int64_t dof = 0;
};

/// Gauss-Newton, with a map linearised again only where its linearisation errs by more than 1 % of a standard deviation (rms):
/// what is put off costs at most 1e-4 of chi2 per measured row, and what the tree does not move a tenth of it per entry. A step
/// that would raise chi2 is not taken: the estimate then has not converged, and wants a join of all maps.
template <int Dim>
class IncrementalEstimate {
 public:
  /// Variables are numbered from 0. One that is anchored stays where it is.
  JoinedIndex add_variable(bool is_pose, const Pose<Dim>& value, bool is_anchored);
  /// Puts a variable of which no map is there yet elsewhere.
  void place(JoinedIndex variable, const Pose<Dim>& value);
  FactorIndex add_factor(MapFactor<Dim> factor);
  /// Takes one out again, for good: the next settling is without it.
  void remove_factor(FactorIndex factor);

  /// To the optimum; `last` are the variables that the next maps will probably touch.
  Settling settle(std::span<const JoinedIndex> last);

  const JoinedVariables<Dim>& variables() const { return variables_; }
  const JoinedVariable<Dim>& variable(JoinedIndex v) const { return variables_[v]; }
  /// As of the last settling.
  KeptEstimate<Dim> kept() { return {shown_.kept(), tree_.kept_factor(), chi2_, dof()}; }
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
  /// Brings `shown_` up to date with what has moved and what is new.
  void show_moved();
  void refer_turned();

  JoinedVariables<Dim> variables_;
  Table<Variable, JoinedIndex> variable_of_column_;
  Table<FactorIndex, Factor> factors_;
  std::vector<FactorIndex> stale_;                                        // factors to be linearised
  SharedTable<JoinedIndex, typename KeptEstimate<Dim>::Variable> shown_;  // as of the last settling
  FrontTree tree_;
  double chi2_ = 0.0;
  std::int64_t rows_ = 0;
  std::int64_t free_ = 0;
  std::size_t steps_ = 0;
  std::size_t looks_ = 0;                    // at factors since chi2 was summed anew
  std::size_t known_ = 0;                    // variables that were there before this settling
  std::map<JoinedIndex, Pose<Dim>> before_;  // where those were that have moved
};

}  // namespace mapjoin
