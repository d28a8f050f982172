// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A joined state that is kept at the optimum of the maps it is made of, while maps and variables are added.

#include <mapjoin/join/incremental/allowance.hpp>
#include <mapjoin/join/incremental/deferred_front.hpp>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/join/incremental/kept_estimate.hpp>
#include <mapjoin/join/incremental/map_factor.hpp>
#include <mapjoin/join/incremental/shared_table.hpp>
#include <mapjoin/solve/minimise_options.hpp>
#include <optional>
#include <span>
#include <utility>
#include <vector>

namespace mapjoin {

/// How the estimate came to its optimum.
struct Settling {
  bool converged = false;
  int iterations = 0;
  std::size_t eliminated = 0;  ///< Variables, over all iterations.
  StepSize moved;              ///< The most that a variable has moved that was there before.
};

/// Gauss-Newton that puts off what costs little (see Allowance). Maps are linearised again only where all of them together err
/// by enough, and variables move only by enough. New maps may be deferred: only what is new moves, and all else has to gain by
/// enough before it does. All this is measured against where things stand, so it does not add up. A step that would raise chi2
/// is not taken: the estimate then has not converged, and wants a join of all maps.
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

  /// Moves only what is new since the last settling. Nothing where that is not enough: all variables are where they were, and
  /// settle() has to follow before anything is asked.
  std::optional<Settling> defer();
  /// To the optimum; `last` are the variables that the next maps will probably touch.
  Settling settle(std::span<const JoinedIndex> last);

  const JoinedVariables<Dim>& variables() const { return variables_; }
  const JoinedVariable<Dim>& variable(JoinedIndex v) const { return variables_[v]; }
  /// As of the last settling or deferral.
  KeptEstimate<Dim> kept() { return {shown_.kept(), tree_.kept_factor(), deferred_.front(), chi2_, dof()}; }
  double chi2() const { return chi2_; }
  /// Measured rows less free entries.
  std::int64_t dof() const { return rows_ - free_; }

 private:
  struct Factor {
    MapFactor<Dim> map;
    std::optional<FrontTree::QuadraticIndex> quadratic;  // of the tree, once it is linearised
    typename MapFactor<Dim>::Fit fit;
    std::size_t met_in = 0;  // the move that looked at it last
  };
  JoinedVariable<Dim>& variable(JoinedIndex v) { return variables_[v]; }
  Factor& factor(FactorIndex f) { return factors_[f]; }
  Allowance allowance() const;
  void sum_chi2();
  void linearise_stale();
  /// Where all maps together err by more than they may: makes those stale that err most.
  void find_stale();
  /// Those new maps again that err; whether there are any.
  bool linearise_new_again();
  bool errs(const Factor& factor) const;
  /// Moves what is new to where the new maps cost least, the rest staying where it is; nothing as of defer().
  std::optional<Settling> settle_new();
  /// Whether all else stands well enough while the new maps, which have so many rows, are deferred.
  bool is_rest_content(std::int64_t rows);
  void enter_deferred();
  /// The free variables of new maps that the tree does not have, each once.
  std::vector<JoinedIndex> new_variables() const;
  /// Moves variables to these entries, one after the other; false where chi2 would rise, all then staying where they are.
  bool take_step(const std::vector<Variable>& columns, const Eigen::VectorXd& entries);
  /// Has the tree stand where these variables do.
  void put_tree_to(const std::vector<JoinedIndex>& variables);
  std::vector<PoseVector<Dim>> steps_of(const std::vector<JoinedIndex>& variables) const;
  /// Brings chi2 and what maps err by up to date, too.
  void move(const std::vector<JoinedIndex>& variables, const std::vector<PoseVector<Dim>>& steps);
  void refer_turned();

  JoinedVariables<Dim> variables_;
  Table<Variable, JoinedIndex> variable_of_column_;
  Table<FactorIndex, Factor> factors_;
  std::vector<FactorIndex> stale_;  // to be linearised before the next update of the tree, perhaps named twice
  std::vector<FactorIndex> new_;    // factors that the tree does not have
  ShownVariables<Dim> shown_;
  FrontTree tree_;
  DeferredFront deferred_;      // of the first of the new factors, in their order
  double gain_ = 0.0;           // what the rest might gain but for deferral,
  double expected_more_ = 0.0;  // and that more with the next map, as far as the last ones tell
  double chi2_ = 0.0;
  double settled_chi2_ = 0.0;
  double error_ = 0.0;  // of all linearisations
  std::int64_t rows_ = 0;
  std::int64_t free_ = 0;
  std::int64_t settled_free_ = 0;
  std::size_t moves_ = 0;
  std::size_t looks_ = 0;  // at factors since chi2 was summed anew
};

}  // namespace mapjoin
