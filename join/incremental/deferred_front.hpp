// SPDX-License-Identifier: BSD-3-Clause
#pragma once
// Quadratics that a tree of fronts has not taken yet: they are solved for their own variables only, while those of the tree
// stay where they are, like the considered states of the Schmidt-Kalman filter.

#include <Eigen/Core>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <memory>
#include <optional>
#include <vector>

namespace mapjoin {

/// The front of some quadratics over the variables that the tree does not have.
class DeferredFront {
 public:
  /// The number of quadratics; k counts them in the order in which they were added.
  std::size_t size() const { return quadratics_.size(); }
  void add(Quadratic quadratic) { quadratics_.push_back(std::move(quadratic)); }
  void change(std::size_t k, Quadratic quadratic) { quadratics_[k] = std::move(quadratic); }
  void remove(std::size_t k) { quadratics_.erase(quadratics_.begin() + static_cast<std::ptrdiff_t>(k)); }
  /// Takes all quadratics out.
  std::vector<Quadratic> take();

  /// Solves for the variables that the tree does not have; there must be a quadratic. These variables should be few, as the
  /// front is dense.
  void solve(const FrontTree& tree);
  /// The front of the last solve(), its frontals ascending; null before. It never changes.
  const std::shared_ptr<const Front>& front() const { return front_; }
  /// The entries of the front's frontals.
  const Eigen::VectorXd& solution() const { return solution_; }

  /// A bound, after solve(), on the decrease of the sum with the tree's quadratics if all variables moved; those of the tree
  /// must be at its optimum. nullopt if a variable is not determined.
  std::optional<double> gain(const FrontTree& tree) const;

 private:
  /// Lays out the front, frontals first, then the separator, and finds its rows for the entries of each quadratic.
  void lay_out(const FrontTree& tree, Front& front);

  std::vector<Quadratic> quadratics_;
  std::vector<std::vector<Eigen::Index>> rows_;
  std::shared_ptr<const Front> front_;
  Eigen::VectorXd solution_;
};

}  // namespace mapjoin
