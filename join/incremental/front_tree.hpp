// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A growing sum of quadratics and its minimum, by a tree of fronts of which a change touches few: those that eliminate the
// variables of what changed, and all above them (the Bayes tree of iSAM2: Kaess et al., IJRR 2012).
//
// The fronts below send up what they sent before. Their variables are solved for again only where what lies above has moved.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front.hpp>
#include <mapjoin/join/incremental/front_plan.hpp>
#include <span>
#include <vector>

namespace mapjoin {

class FrontTree {
 public:
  /// Variables and quadratics are numbered from 0 in the order they were added.
  Index add_variable(int dof);
  Index add_quadratic(Quadratic quadratic);
  /// H and b in the place of the former ones, over the same variables.
  void change_quadratic(Index quadratic, Eigen::MatrixXd H, Eigen::VectorXd b);

  /// Eliminates again what is touched by all that was added and changed since the last time, the variables `last` after all
  /// others, and solves. Returns how many variables were eliminated.
  std::size_t update(std::span<const Index> last);
  /// Where the sum is least: the entries of a variable.
  Eigen::Map<const Eigen::VectorXd> solution(Index variable) const;
  /// The variables that the last update moved by more than a thousandth of a standard deviation; the others stand where they
  /// stood.
  const std::vector<Index>& moved() const { return moved_; }
  /// Puts a variable elsewhere: the next update then looks at all of them.
  void set_solution(Index variable, const Eigen::Ref<const Eigen::VectorXd>& entries);

 private:
  struct Node {
    Front front;
    Index parent = -1;
    std::vector<Index> children;
    std::vector<Index> quadratics;
    bool is_open = false;   // about to be eliminated again
    bool is_fresh = false;  // not yet solved
  };
  struct Variable {
    int dof;
    Eigen::Index offset;       // in solution_
    Index node = -1;           // that eliminates it
    Index place = -1;          // among the variables that are being eliminated
    Eigen::Index row = -1;     // in the front that is being assembled
    std::size_t moved_in = 0;  // the update that moved it last
  };
  struct Opened;

  Variable& variable(Index v) { return variables_[static_cast<std::size_t>(v)]; }
  const Variable& variable(Index v) const { return variables_[static_cast<std::size_t>(v)]; }
  Node& node(Index n) { return nodes_[static_cast<std::size_t>(n)]; }
  const Node& node(Index n) const { return nodes_[static_cast<std::size_t>(n)]; }
  Quadratic& quadratic(Index q) { return quadratics_[static_cast<std::size_t>(q)]; }
  const Quadratic& quadratic(Index q) const { return quadratics_[static_cast<std::size_t>(q)]; }

  void open_upwards(Index node, Opened& opened);
  Opened open_touched();
  void order(std::span<const Index> last, Opened& opened);
  FrontPlan plan(const Opened& opened) const;
  /// New nodes in the place of the open ones, in the plan's order, with their quadratics and orphans.
  std::vector<Index> rebuild(const Opened& opened, const FrontPlan& plan);
  void eliminate(const Opened& opened, const PlannedFront& planned, Index node);
  Index new_node();
  /// The sum of a node's quadratics and its children's messages, over the given variables.
  Quadratic assembled(const Node& node, std::vector<Index> variables);
  void add_to(Quadratic& sum, const Quadratic& part);
  void solve();
  bool is_above_moved(const Node& node) const;
  void solve_front(const Front& front);

  std::vector<Variable> variables_;
  std::vector<Quadratic> quadratics_;
  std::vector<Index> node_of_;  // per quadratic, or -1
  std::vector<Index> touched_;  // quadratics since the last update
  std::vector<Node> nodes_;
  std::vector<Index> unused_;  // nodes
  std::vector<Index> roots_;
  std::vector<double> solution_;
  std::vector<Index> moved_;
  std::size_t updates_ = 0;
  bool is_displaced_ = false;
};

}  // namespace mapjoin
