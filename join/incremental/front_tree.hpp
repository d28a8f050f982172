// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// A growing sum of quadratics and its minimum, by a tree of fronts of which a change touches few: those that eliminate the
// variables of what changed, and all above them (the Bayes tree of iSAM2: Kaess et al., IJRR 2012).
//
// These are planned and eliminated again as normal equations of their own (NormalEquations), to which the fronts below send
// what they sent before. The variables of fronts below are solved for again only where what lies above has moved.

#include <Eigen/Core>
#include <mapjoin/model/ids.hpp>
#include <mapjoin/solve/normal_equations.hpp>
#include <span>
#include <vector>

namespace mapjoin {

/// A quadratic δᵀHδ - 2 bᵀδ over some variables' entries, one after the other. Only the lower triangle of H counts.
struct Quadratic {
  std::vector<Index> variables;
  Eigen::MatrixXd H;
  Eigen::VectorXd b;
};

class FrontTree {
 public:
  /// Variables and quadratics are numbered from 0 in the order they were added.
  Index add_variable(int dof);
  Index add_quadratic(Quadratic quadratic);
  /// H and b in the place of the former ones, over the same variables.
  void change_quadratic(Index quadratic, Eigen::MatrixXd H, Eigen::VectorXd b);

  /// Eliminates again what is touched by all that was added and changed since the last time, the variables `last` after all
  /// others, and solves. Variables that nothing determines stay where they are. Returns how many variables were eliminated.
  std::size_t update(std::span<const Index> last);
  /// Where the sum is least: the entries of a variable.
  Eigen::Map<const Eigen::VectorXd> solution(Index variable) const;
  /// The variables that the last update moved by more than a thousandth of a standard deviation; the others stand where they
  /// stood.
  const std::vector<Index>& moved() const { return moved_; }
  /// Puts a variable elsewhere: the next update then looks at all of them.
  void set_solution(Index variable, const Eigen::Ref<const Eigen::VectorXd>& entries);

 private:
  /// Variables that are eliminated together; y = L_JJ⁻¹ b_J. What is left over the separator goes to the parent.
  struct Node {
    std::vector<Index> frontals;
    Quadratic update;   // over the separator
    Eigen::MatrixXd L;  // L_JJ over L_RJ
    Eigen::VectorXd y;
    Index parent = -1;
    std::vector<Index> children;
    bool is_open = false;   // about to be eliminated again
    bool is_fresh = false;  // not yet solved
  };
  struct Variable {
    int dof;
    Eigen::Index offset;  // in solution_
    std::vector<Index> quadratics{};
    Index node = -1;           // that eliminates it
    Index place = kConstant;   // among the variables that are being eliminated
    std::size_t moved_in = 0;  // the update that moved it last
  };
  /// What is eliminated again.
  struct Opened {
    std::vector<Index> nodes;
    std::vector<Index> variables;            // those to be eliminated last at the end
    std::vector<const Quadratic*> summands;  // that concern them alone, then what the orphans send
    std::size_t quadratic_count = 0;         // of the summands
    std::vector<Index> orphans;              // nodes below the open ones
    Index last_count = 0;
  };
  struct Given;

  Variable& variable(Index v) { return variables_[static_cast<std::size_t>(v)]; }
  const Variable& variable(Index v) const { return variables_[static_cast<std::size_t>(v)]; }
  Node& node(Index n) { return nodes_[static_cast<std::size_t>(n)]; }
  const Node& node(Index n) const { return nodes_[static_cast<std::size_t>(n)]; }
  Quadratic& quadratic(Index q) { return quadratics_[static_cast<std::size_t>(q)]; }
  const Quadratic& quadratic(Index q) const { return quadratics_[static_cast<std::size_t>(q)]; }

  void open_upwards(Index node, Opened& opened);
  Opened open_touched();
  void order(std::span<const Index> last, Opened& opened);
  void find_summands(Opened& opened) const;
  NormalEquations pattern_of(const Opened& opened) const;
  /// The summands over the places of the opened variables.
  Given given_by(const Opened& opened, const NormalEquations& equations) const;
  /// New nodes in the place of the open ones, of a factorisation of what is opened.
  void rebuild(const Opened& opened, const NormalEquations& equations, const Given& given, const Supernodes& supernodes);
  void take(Index node, const Supernode& supernode, const std::vector<Index>& variable_at);
  void link(const std::vector<Index>& nodes, const Supernodes& supernodes, const std::vector<std::size_t>& supernode_at,
            const std::vector<Eigen::VectorXd>& given);
  Index new_node();
  void solve();
  bool is_above_moved(const Node& node) const;
  void solve_node(const Node& node);
  /// The solution over variables, of so many entries.
  Eigen::VectorXd gathered(const std::vector<Index>& variables, Eigen::Index size) const;

  std::vector<Variable> variables_;
  std::vector<Quadratic> quadratics_;
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
