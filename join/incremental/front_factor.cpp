// SPDX-License-Identifier: BSD-3-Clause
#include <mapjoin/join/incremental/front_factor.hpp>
#include <set>
#include <unordered_map>
#include <utility>

namespace mapjoin {
namespace {

/// The rows of variables in a dense matrix; each new variable gets the next ones.
class RowNumbers {
 public:
  explicit RowNumbers(const SharedTable<Variable, FrontFactor::Eliminated>& variables) : variables_(variables) {}
  Eigen::Index size() const { return size_; }
  void number(std::span<const Variable> variables) {
    for (const Variable v : variables) {
      if (first_.try_emplace(v.value, size_).second) size_ += variables_[v].dof;
    }
  }
  bool has(Variable v) const { return first_.contains(v.value); }
  /// The rows of some variables, one after the other.
  std::vector<Eigen::Index> of(std::span<const Variable> variables) const {
    std::vector<Eigen::Index> rows;
    for (const Variable v : variables) {
      Eigen::Index row = first_.at(v.value);
      for (const Eigen::Index end = row + variables_[v].dof; row < end; ++row) rows.push_back(row);
    }
    return rows;
  }

 private:
  const SharedTable<Variable, FrontFactor::Eliminated>& variables_;
  std::unordered_map<std::int32_t, Eigen::Index> first_;
  Eigen::Index size_ = 0;
};

/// The number of leading rows that are all zero.
Eigen::Index leading_zero_rows(const Eigen::MatrixXd& Y) {
  Eigen::Index count = 0;
  while (count < Y.rows() && Y.row(count).isZero(0.0)) ++count;
  return count;
}

}  // namespace

std::vector<const Front*> FrontFactor::way_to_root(std::span<const Variable> of, const Front* deferred) const {
  std::vector<const Front*> way;
  std::set<NodeIndex> met;
  const auto go_up_from = [&](std::span<const Variable> variables) {
    for (const Variable v : variables) {
      std::vector<const Front*> own;  // up to a front that was met before
      for (NodeIndex n = this->variables[v].node; n != kNone && met.insert(n).second; n = nodes[n].parent) {
        own.push_back(nodes[n].front.get());
      }
      way.insert(way.begin(), own.begin(), own.end());
    }
  };
  go_up_from(of);
  if (deferred) go_up_from(deferred->separator);
  if (deferred) way.insert(way.begin(), deferred);
  return way;
}

std::optional<Eigen::MatrixXd> FrontFactor::covariance(std::span<const Variable> of, const Front* deferred) const {
  Eigen::Index size = 0;
  for (const Variable v : of) size += variables[v].dof;
  return inverse_form(of, Eigen::MatrixXd::Identity(size, size), deferred);
}

/// YᵀY with L Y = R; rows of Y are nonzero only on the way from the variables' fronts to the root.
std::optional<Eigen::MatrixXd> FrontFactor::inverse_form(std::span<const Variable> of, const Eigen::MatrixXd& R,
                                                         const Front* deferred) const {
  const std::vector<const Front*> way = way_to_root(of, deferred);
  RowNumbers rows(variables);
  for (const Front* front : way) rows.number(front->frontals);
  for (const Variable v : of) {
    if (!rows.has(v)) return std::nullopt;  // nothing is known of it
  }
  for (const Front* front : way) rows.number(front->separator);  // FrontTree::kOne, too, which no front solves for
  Eigen::MatrixXd rhs = Eigen::MatrixXd::Zero(rows.size(), R.cols());
  rhs(rows.of(of), Eigen::all) = R;
  Eigen::MatrixXd form = Eigen::MatrixXd::Zero(R.cols(), R.cols());
  for (const Front* front : way) {
    if (front->is_singular) return std::nullopt;
    Eigen::MatrixXd Y = rhs(rows.of(front->frontals), Eigen::all);
    const Eigen::Index skipped = leading_zero_rows(Y);  // which stay zero: variables at the end of a wide front are cheap
    auto rest = Y.bottomRows(Y.rows() - skipped);
    const auto L = front->L.bottomRightCorner(front->L.rows() - skipped, rest.rows());
    // Column by column, so that L need not be packed.
    for (auto column : rest.colwise()) L.topRows(rest.rows()).triangularView<Eigen::Lower>().solveInPlace(column);
    form.noalias() += rest.transpose() * rest;
    rhs(rows.of(front->separator), Eigen::all) -= L.bottomRows(L.rows() - rest.rows()) * rest;
  }
  return form;
}

Eigen::VectorXd Front::solved(const Eigen::VectorXd& separator) const {
  Eigen::VectorXd solution = -(L.bottomRows(separator.size()).transpose() * separator);
  L.topRows(L.cols()).triangularView<Eigen::Lower>().transpose().solveInPlace(solution);
  return solution;
}

}  // namespace mapjoin
