// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A growing sum of quadratics and its minimum, by a tree of fronts of which a change touches few: those that eliminate the
// variables of what changed, and all above them (the Bayes tree of iSAM2: Kaess et al., IJRR 2012).
//
// These, and fronts below them that send many rows for what they have eliminated, are eliminated again (QuadraticSum); the
// other fronts below send what they sent before. Their variables are solved for again only where what lies above has moved.

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
  /// H in the place of the former one, over the same variables.
  void change_quadratic(QuadraticIndex quadratic, Eigen::MatrixXd H);
  /// Takes one out of the sum, for good.
  void remove_quadratic(QuadraticIndex quadratic);

  /// Eliminates again what all that was added and changed since the last time touches, the variables `last` after all others,
  /// and solves. Variables that nothing determines stay where they are, and so do those that would move, in a front of
  /// `n` entries, by less than n `no_move` squared standard deviations. Returns how many variables were eliminated. Where it
  /// throws, for want of memory, the tree is of no use any more; factors that were kept are.
  std::size_t update(std::span<const Variable> last, double no_move = 1e-6);
  /// Where the sum is least, but for what stays where it is: the entries of a variable, and of several.
  Eigen::Map<const Eigen::VectorXd> solution(Variable v) const;
  Eigen::VectorXd solution(const std::vector<Variable>& variables) const;
  int dof(Variable v) const { return factor_.variables[v].dof; }
  /// Whether an update has eliminated it.
  bool has(Variable v) const { return node_of(v) != kNone; }
  /// As of the last update.
  const FrontFactor& factor() const { return factor_; }
  FrontFactor kept_factor() { return factor_.kept(); }
  /// The variables that the last update moved; the others stand where they stood.
  const std::vector<Variable>& moved() const { return moved_; }
  /// Puts a variable elsewhere: the next update then looks at all of them, where it has this one.
  void set_solution(Variable v, const Eigen::Ref<const Eigen::VectorXd>& entries);

 private:
  using NodeIndex = FrontFactor::NodeIndex;
  static constexpr NodeIndex kNone = FrontFactor::kNone;

  /// What only the tree needs of a front. What solves and covariances need is in the factor, which kept states share.
  struct Node {
    Quadratic update;  // that the front sends, over its separator; nothing of the root
    std::vector<NodeIndex> children;
    std::vector<QuadraticIndex> quadratics;  // whose first variable it eliminates
    Eigen::Index rows = 0;                   // that it and all below eliminate
    bool is_open = false;                    // about to be eliminated again
    bool is_fresh = false;                   // not yet solved
  };
  struct Values {
    Eigen::Index offset = 0;   // of its entries in the solution
    std::size_t moved_in = 0;  // the update that moved it last
  };
  struct Summand {
    Quadratic quadratic;     // of no variables once it is removed
    NodeIndex node = kNone;  // that has it
  };
  /// What is eliminated again.
  struct Opened {
    std::vector<NodeIndex> nodes;
    std::vector<Variable> variables;  // ascending
    std::vector<QuadraticIndex> quadratics;
    std::vector<NodeIndex> orphans;  // nodes below the open ones
  };

  void open_upwards(NodeIndex node, Opened& opened);
  bool is_removed(QuadraticIndex q) const { return quadratics_[q].quadratic.variables.empty(); }
  Opened open_touched();
  /// Its variables, its quadratics, and what is below it: open, too, where it is bulky.
  void take_open(NodeIndex node, Opened& opened);
  /// Whether it sends much for what it and all below it have eliminated.
  bool is_bulky(NodeIndex node) const;
  /// The sum to eliminate: the quadratics, then what the orphans send.
  QuadraticSum sum_of(const Opened& opened, const std::set<Variable>& last) const;
  std::size_t eliminate_touched(std::span<const Variable> last);
  /// Until attach() the tree is not whole: its root, variables and orphans still name these nodes.
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
  std::vector<QuadraticIndex> touched_;  // since the last update, each once
  Table<NodeIndex, Node> nodes_;
  std::vector<NodeIndex> unused_;
  NodeIndex root_ = kNone;
  std::vector<double> solution_;
  std::vector<Variable> moved_;
  std::size_t updates_ = 0;
  bool is_displaced_ = false;
};

}  // namespace mapjoin
