// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A joined state kept at the optimum of its maps while maps and variables are added.

#include <algorithm>
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

/// The result of settling the estimate at its optimum.
struct Settling {
  bool converged = false;
  int iterations = 0;
  std::size_t eliminated = 0;  ///< Variables eliminated, over all iterations.
  StepSize moved;              ///< Largest move of a variable that was there before.
};

/// Gauss-Newton that defers work of little effect (see Allowance). Maps are linearised again only if all of them together err
/// by enough, and variables move only by enough. New maps may be deferred: only new variables move, until the others have
/// enough to gain. Errors are measured against the present state, so they do not add up. A step that would raise chi2 is not
/// taken: the estimate has then not converged, and needs a join of all maps.
template <int Dim>
class IncrementalEstimate {
 public:
  /// Adds a variable, anchored or free; variables are numbered from 0.
  JoinedIndex add_variable(bool is_pose, const Pose<Dim>& value, bool is_anchored);
  /// Moves a variable that has no map yet.
  void place(JoinedIndex variable, const Pose<Dim>& value) {
    variables_[variable].reference = variables_[variable].value = value;
  }
  FactorIndex add_factor(MapFactor<Dim> factor);
  /// Removes a factor for good: the next settling is without it.
  void remove_factor(FactorIndex factor);

  /// Moves only the variables that are new since the last settling. nullopt if that is not enough: all variables are then where
  /// they were, and settle() must follow before anything is asked.
  std::optional<Settling> defer();
  /// Moves all variables to the optimum; `last` are those that the next maps will probably touch.
  Settling settle(std::span<const JoinedIndex> last);

  const JoinedVariables<Dim>& variables() const { return variables_; }
  const JoinedVariable<Dim>& variable(JoinedIndex v) const { return variables_[v]; }
  /// The estimate as of the last settling or deferral.
  KeptEstimate<Dim> kept() { return {shown_.kept(), tree_.kept_factor(), deferred_.front(), chi2_, dof()}; }
  double chi2() const { return chi2_; }
  /// Measured rows less free entries.
  std::int64_t dof() const { return rows_ - free_; }

 private:
  struct Factor {
    MapFactor<Dim> map;
    std::optional<FrontTree::QuadraticIndex> quadratic;  // in the tree, once it has the map
    typename MapFactor<Dim>::Fit fit;
    std::size_t met_in = 0;  // the move that met it last
  };
  JoinedVariable<Dim>& variable(JoinedIndex v) { return variables_[v]; }
  Factor& factor(FactorIndex f) { return factors_[f]; }
  Allowance allowance() const { return {std::min(chi2_, settled_chi2_), rows_, free_}; }
  void sum_chi2();
  void linearise_stale();
  /// Marks the maps that err most as stale if all together err by more than they may.
  void find_stale();
  /// Linearises the new maps that err again; true if there are any.
  bool linearise_new_again();
  bool errs(const Factor& factor) const;
  /// Moves the new variables to where the new maps cost least, with the others held; nullopt if that does not converge.
  std::optional<Settling> settle_new();
  /// True if the other variables may stay where they are while the new maps, of so many rows, are deferred.
  bool is_rest_content(std::int64_t rows);
  void enter_deferred();
  /// The free variables of new maps that the tree does not have, each once.
  std::vector<JoinedIndex> new_variables() const;
  /// Moves variables to these entries, given one after the other. False if chi2 would rise; all then stay where they are.
  bool take_step(const std::vector<Variable>& columns, const Eigen::VectorXd& entries);
  /// Moves the tree's variables to where these are.
  void put_tree_to(const std::vector<JoinedIndex>& variables);
  std::vector<PoseVector<Dim>> steps_of(const std::vector<JoinedIndex>& variables) const;
  /// Moves variables, and updates chi2 and the errors of maps.
  void move(const std::vector<JoinedIndex>& variables, const std::vector<PoseVector<Dim>>& steps);
  bool refer_turned();

  JoinedVariables<Dim> variables_;
  Table<Variable, JoinedIndex> variable_of_column_;
  Table<FactorIndex, Factor> factors_;
  std::vector<FactorIndex> stale_;  // to be linearised before the next update of the tree, perhaps named twice
  std::vector<FactorIndex> new_;    // factors that the tree does not have
  ShownVariables<Dim> shown_;
  FrontTree tree_;
  DeferredFront deferred_;      // quadratics of the first of the new factors, in their order
  double gain_ = 0.0;           // decrease of chi2 that deferral may miss
  double expected_more_ = 0.0;  // its expected growth by the next map
  double chi2_ = 0.0;
  double settled_chi2_ = 0.0;
  double error_ = 0.0;  // sum over all linearisations
  std::int64_t rows_ = 0;
  std::int64_t free_ = 0;
  std::int64_t settled_free_ = 0;
  std::size_t moves_ = 0;
  std::size_t looks_ = 0;  // looks at factors since chi2 was summed anew
};

}  // namespace mapjoin
