// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Quadratics that a tree of fronts has not taken yet: their own variables are solved for, and all that the tree has stays where
// it is, as what the Schmidt-Kalman filter only considers.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace mapjoin {

/// The sum of some quadratics, as far as it depends on variables that the tree does not have.
class DeferredFront {
 public:
  /// Their number, and the k-th of them.
  std::size_t size() const { return quadratics_.size(); }
  void add(Quadratic quadratic) { quadratics_.push_back(std::move(quadratic)); }
  void change(std::size_t k, Quadratic quadratic) { quadratics_[k] = std::move(quadratic); }
  void remove(std::size_t k) { quadratics_.erase(quadratics_.begin() + static_cast<std::ptrdiff_t>(k)); }
  /// Hands all over, and has none any more.
  std::vector<Quadratic> take();

  /// Solves for the variables that the tree does not have, of one quadratic or more. There should be few: the front is dense.
  void solve(const FrontTree& tree);
  /// As of the last solve(), its frontals ascending; null before. It never changes.
  const std::shared_ptr<const Front>& front() const { return front_; }
  /// The entries of its frontals.
  const Eigen::VectorXd& solution() const { return solution_; }

  /// A bound, after solve(), on how far the sum with the tree's could fall if all variables moved, these being at the tree's
  /// optimum: nothing where a variable is not determined.
  std::optional<double> gain(const FrontTree& tree) const;

 private:
  /// The front's rows that the entries of each quadratic have: first those of its frontals, then those of its separator.
  void lay_out(const FrontTree& tree, Front& front);

  std::vector<Quadratic> quadratics_;
  std::vector<std::vector<Eigen::Index>> rows_;
  std::shared_ptr<const Front> front_;
  Eigen::VectorXd solution_;
};

}  // namespace mapjoin
