// SPDX-License-Identifier: BSD-3-Clause
#include <map>
#include <mapjoin/join/incremental/deferred_front.hpp>
#include <mapjoin/solve/engines/frontal_matrix.hpp>
#include <span>
#include <utility>

namespace mapjoin {
namespace {

/// Sets the first row of each variable, in this order; returns the row behind the last one.
Eigen::Index number_rows(std::map<Variable, Eigen::Index>& first_rows, Eigen::Index row, const FrontTree& tree) {
  for (auto& [v, first] : first_rows) first = std::exchange(row, row + tree.dof(v));
  return row;
}

}  // namespace

std::vector<Quadratic> DeferredFront::take() {
  front_ = nullptr;
  return std::exchange(quadratics_, {});
}

void DeferredFront::lay_out(const FrontTree& tree, Front& front) {
  std::map<Variable, Eigen::Index> own;
  std::map<Variable, Eigen::Index> others;
  for (const Quadratic& quadratic : quadratics_) {
    for (const Variable v : quadratic.variables) (tree.has(v) ? others : own).emplace(v, 0);
  }
  const Eigen::Index width = number_rows(own, 0, tree);
  front.L = Eigen::MatrixXd::Zero(number_rows(others, width, tree), width);
  for (const auto& [v, row] : own) front.frontals.push_back(v);
  for (const auto& [v, row] : others) front.separator.push_back(v);
  rows_.clear();
  for (const Quadratic& quadratic : quadratics_) {
    auto& rows = rows_.emplace_back();
    for (const Variable v : quadratic.variables) {
      const Eigen::Index first = (tree.has(v) ? others : own).at(v);
      for (int entry = 0; entry < tree.dof(v); ++entry) rows.push_back(first + entry);
    }
  }
}

void DeferredFront::solve(const FrontTree& tree) {
  auto front = std::make_shared<Front>();
  lay_out(tree, *front);
  const Eigen::Index width = front->L.cols();
  const Eigen::Index below = front->L.rows() - width;
  for (std::size_t k = 0; k < quadratics_.size(); ++k) {
    const Quadratic& quadratic = quadratics_[k];
    for (Eigen::Index column = 0; column < quadratic.H.cols(); ++column) {
      const Eigen::Index to = rows_[k][static_cast<std::size_t>(column)];
      if (to >= width) continue;
      for (Eigen::Index row = 0; row < quadratic.H.rows(); ++row) {
        front->L(rows_[k][static_cast<std::size_t>(row)], to) += quadratic.entry(row, column);
      }
    }
  }
  const Eigen::VectorXd diagonal = front->L.diagonal();
  const Eigen::OuterStride<> stride(front->L.rows());
  const DenseBlock L_JJ(front->L.data(), width, width, stride);
  front->is_singular = !eliminate({L_JJ, {nullptr, 0, 0, stride}}, diagonal).empty();
  divide_by_transpose({front->L.data(), width, width, stride}, {front->L.data() + width, below, width, stride});
  solution_ = front->solved(tree.solution(front->separator));
  front_ = std::move(front);
}

/// With half the gradient g over the tree's variables, H the tree's information and S that of the deferred quadratics over
/// them, the decrease is gᵀ(H + S)⁻¹g ≤ (1 - t)² gᵀH⁻¹g + t² gᵀS⁺g for any t. The last form is at most the cost of these
/// quadratics, as S alone could save no more; with the best t the bound is the inverse of the sum of the two inverses.
std::optional<double> DeferredFront::gain(const FrontTree& tree) const {
  if (front_->is_singular) return std::nullopt;
  Eigen::VectorXd at(front_->L.rows());
  at << solution_, tree.solution(front_->separator);
  Eigen::VectorXd half_gradient = Eigen::VectorXd::Zero(at.size());
  for (std::size_t k = 0; k < quadratics_.size(); ++k) {
    half_gradient(rows_[k]) += quadratics_[k].H.selfadjointView<Eigen::Lower>() * Eigen::VectorXd(at(rows_[k]));
  }
  const double cost = at.dot(half_gradient);
  const auto separator = std::span(front_->separator).subspan(1);  // without FrontTree::kOne, the least of all
  const auto form = tree.factor().inverse_form(separator, half_gradient.tail(at.size() - solution_.size() - 1));
  if (!form) return std::nullopt;
  const double tree_alone = form->value();
  return tree_alone > 0.0 ? tree_alone * cost / (tree_alone + cost) : 0.0;
}

}  // namespace mapjoin
