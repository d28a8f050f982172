// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A growing sum of quadratics and its minimum, by a tree of fronts. A change touches few of them: those that eliminate the
// variables of changed quadratics, and all above (the Bayes tree of iSAM2: Kaess et al., IJRR 2012).
//
// Touched fronts are eliminated again (QuadraticSum), and so are fronts below them with updates that are large for what they
// have eliminated; the other fronts below keep their updates. Their variables are solved for again only if variables above have
// moved.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front_factor.hpp>
#include <mapjoin/join/incremental/quadratic_sum.hpp>
#include <set>
#include <span>
#include <vector>

namespace mapjoin {

class FrontTree {
 public:
  static constexpr Variable kOne = 0;
  using QuadraticIndex = StrongIndex<struct QuadraticTag>;

  FrontTree();
  Variable add_variable(int dof);
  QuadraticIndex add_quadratic(Quadratic quadratic);
  /// Replaces the H of a quadratic, over the same variables.
  void change_quadratic(QuadraticIndex quadratic, Eigen::MatrixXd H);
  /// Removes a quadratic from the sum, for good.
  void remove_quadratic(QuadraticIndex quadratic);

  /// Eliminates again all fronts touched since the last time, the variables `last` after all others, and solves. The
  /// variables of a front of n entries that would move by no more than n `no_move` squared standard deviations stay where they
  /// are; of the others, entries that nothing determines become 0. Returns the number of variables eliminated. If it throws,
  /// for want of memory, the tree is unusable; factors that were kept stay valid.
  std::size_t update(std::span<const Variable> last, double no_move = 1e-6);
  /// The entries of a variable, or of several, at the minimum of the sum, but for those that stay where they are (see
  /// update()).
  Eigen::Map<const Eigen::VectorXd> solution(Variable v) const;
  Eigen::VectorXd solution(const std::vector<Variable>& variables) const;
  int dof(Variable v) const { return factor_.variables[v].dof; }
  /// True if an update has eliminated the variable.
  bool has(Variable v) const { return node_of(v) != kNone; }
  /// The factor as of the last update.
  const FrontFactor& factor() const { return factor_; }
  FrontFactor kept_factor() { return factor_.kept(); }
  /// The variables that the last update moved; the others are where they were.
  const std::vector<Variable>& moved() const { return moved_; }
  /// Sets the entries of a variable; if the tree has it, the next update visits all fronts.
  void set_solution(Variable v, const Eigen::Ref<const Eigen::VectorXd>& entries);

 private:
  using NodeIndex = FrontFactor::NodeIndex;
  static constexpr NodeIndex kNone = FrontFactor::kNone;

  /// The data of a front that only the tree needs. Those for solves and covariances are in the factor, which kept states share.
  struct Node {
    Quadratic update;  // sent to the parent, over the separator; empty for the root
    std::vector<NodeIndex> children;
    std::vector<QuadraticIndex> quadratics;  // those whose first variable it eliminates
    Eigen::Index rows = 0;                   // eliminated by the front and all below it
    bool is_open = false;                    // about to be eliminated again
    bool is_fresh = false;                   // not yet solved
  };
  struct Values {
    Eigen::Index offset = 0;   // of the variable's entries in the solution
    std::size_t moved_in = 0;  // the update that moved it last
  };
  struct Summand {
    Quadratic quadratic;     // without variables once it is removed
    NodeIndex node = kNone;  // node that has it
  };
  /// The part of the tree and of the sum that is eliminated again.
  struct Opened {
    std::vector<NodeIndex> nodes;
    std::vector<Variable> variables;  // ascending
    std::vector<QuadraticIndex> quadratics;
    std::vector<NodeIndex> orphans;  // nodes below the open ones
  };

  void open_upwards(NodeIndex node, Opened& opened);
  bool is_removed(QuadraticIndex q) const { return quadratics_[q].quadratic.variables.empty(); }
  Opened open_touched();
  /// Takes the variables and quadratics of an open node, and opens the bulky nodes below it; the others are orphans.
  void take_open(NodeIndex node, Opened& opened);
  /// True if a node's update is large for what it and all below it have eliminated.
  bool is_bulky(NodeIndex node) const;
  /// The sum to eliminate: the quadratics, then the updates of the orphans.
  QuadraticSum sum_of(const Opened& opened, const std::set<Variable>& last) const;
  std::size_t eliminate_touched(std::span<const Variable> last);
  /// Removes nodes. Until attach() the tree is not whole: its root, variables and orphans still name them.
  void remove(const std::vector<NodeIndex>& nodes);
  /// Puts new nodes in the place of the open ones: above the orphans, with the quadratics.
  void attach(std::vector<SumNode> fresh, const Opened& opened);
  void put(NodeIndex node, SumNode eliminated);
  NodeIndex new_node();
  const Front& front(NodeIndex node) const { return *factor_.nodes[node].front; }
  NodeIndex parent(NodeIndex node) const { return factor_.nodes[node].parent; }
  NodeIndex node_of(Variable v) const { return factor_.variables[v].node; }
  void solve(double no_move);
  bool is_above_moved(const Front& below) const;
  void solve_front(const Front& next, double no_move);

  FrontFactor factor_;
  Table<Variable, Values> variables_;
  Table<QuadraticIndex, Summand> quadratics_;
  std::vector<QuadraticIndex> touched_;  // since the last update, perhaps named twice
  Table<NodeIndex, Node> nodes_;
  std::vector<NodeIndex> unused_;
  NodeIndex root_ = kNone;
  std::vector<double> solution_;
  std::vector<Variable> moved_;
  std::size_t updates_ = 0;
  bool is_displaced_ = false;
};

}  // namespace mapjoin
