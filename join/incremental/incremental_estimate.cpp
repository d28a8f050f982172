// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <iterator>
#include <mapjoin/join/incremental/incremental_estimate.hpp>
#include <mapjoin/model/lists.hpp>
#include <utility>

namespace mapjoin {
namespace {

constexpr int kMostIterations = 50;
/// The number of new entries beyond which a deferred front, which is dense, costs more than it saves.
constexpr std::int64_t kMostDeferredEntries = 64;
/// The share of the allowed error that is left once some maps are linearised again.
constexpr double kErrorLeft = 0.5;
/// The turn of a pose (rad) since its reference beyond which it gets a new one: rotation vectors are good up to π.
constexpr double kMostTurn = 1.0;

}  // namespace

template <int Dim>
JoinedIndex IncrementalEstimate<Dim>::add_variable(bool is_pose, const Pose<Dim>& value, bool is_anchored) {
  JoinedVariable<Dim>& added = variables_.emplace_back();
  added.is_pose = is_pose;
  added.reference = added.value = value;
  const JoinedIndex v(variables_.size() - 1);
  if (is_anchored) return v;
  added.column = tree_.add_variable(added.dof());
  variable_of_column_.resize(added.column.position() + 1);
  variable_of_column_[added.column] = v;
  free_ += added.dof();
  return v;
}

template <int Dim>
FactorIndex IncrementalEstimate<Dim>::add_factor(MapFactor<Dim> map) {
  const FactorIndex f(factors_.size());
  for (const JoinedIndex v : map.variables()) {
    if (v != kJoinedWorld) variable(v).factors.push_back(f);
  }
  rows_ += map.rows();
  Factor& added = factors_.emplace_back(Factor{std::move(map), {}, {}, 0});
  added.fit.chi2 = added.map.chi2(variables_);
  chi2_ += added.fit.chi2;
  new_.push_back(f);
  return f;
}

template <int Dim>
void IncrementalEstimate<Dim>::remove_factor(FactorIndex f) {
  Factor& removed = factor(f);
  for (const JoinedIndex v : removed.map.variables()) {
    if (v != kJoinedWorld) std::erase(variable(v).factors, f);
  }
  rows_ -= removed.map.rows();
  chi2_ -= removed.fit.chi2;
  error_ -= std::exchange(removed.fit, {}).error;
  std::erase(stale_, f);
  if (const auto fresh = std::ranges::find(new_, f); fresh != new_.end()) {
    const auto k = static_cast<std::size_t>(fresh - new_.begin());
    if (k < deferred_.size()) deferred_.remove(k);
    new_.erase(fresh);
  }
  if (removed.quadratic) tree_.remove_quadratic(*removed.quadratic);
}

template <int Dim>
std::optional<Settling> IncrementalEstimate<Dim>::defer() {
  const bool is_hopeless = std::exchange(expected_more_, 0.5 * expected_more_) > allowance().gain();
  const bool is_all_new = new_.size() == factors_.size();
  if (is_hopeless || is_all_new || new_.empty() || free_ - settled_free_ > kMostDeferredEntries) return std::nullopt;
  std::int64_t rows = 0;
  for (std::size_t k = deferred_.size(); k < new_.size(); ++k) {
    deferred_.add(factor(new_[k]).map.linearise(variables_));
    rows += factor(new_[k]).map.rows();
  }
  const std::vector<JoinedIndex> moved = new_variables();
  const std::vector<PoseVector<Dim>> from = steps_of(moved);
  auto settling = settle_new();
  if (!settling || !is_rest_content(rows)) {
    move(moved, from);
    deferred_.take();  // linearised at values that are given up
    return std::nullopt;
  }
  settling->moved = shown_.show(variables_);
  return settling;
}

template <int Dim>
std::optional<Settling> IncrementalEstimate<Dim>::settle_new() {
  Settling settling;
  do {
    if (++settling.iterations > kMostIterations) return std::nullopt;
    deferred_.solve(tree_);
    if (!take_step(deferred_.front()->frontals, deferred_.solution())) return std::nullopt;
  } while (linearise_new_again());
  settling.converged = true;
  return settling;
}

/// The gain that the others miss may be as large as allowed, its expected growth one standard deviation in each row.
template <int Dim>
bool IncrementalEstimate<Dim>::is_rest_content(std::int64_t rows) {
  const std::optional<double> gain = deferred_.gain(tree_);
  if (!gain) return false;
  expected_more_ = *gain - std::exchange(gain_, *gain);
  return gain_ <= allowance().gain() && expected_more_ <= static_cast<double>(rows);
}

template <int Dim>
bool IncrementalEstimate<Dim>::linearise_new_again() {
  bool erred = false;
  for (std::size_t k = 0; k < new_.size(); ++k) {
    Factor& fresh = factor(new_[k]);
    if (!errs(fresh)) continue;
    deferred_.change(k, fresh.map.linearise(variables_));
    error_ -= std::exchange(fresh.fit.error, 0.0);
    erred = true;
  }
  return erred;
}

/// Gives the tree the maps that it does not have, and moves their variables in it to where they are.
template <int Dim>
void IncrementalEstimate<Dim>::enter_deferred() {
  std::vector<Quadratic> quadratics = deferred_.take();
  for (std::size_t k = 0; k < new_.size(); ++k) {
    Factor& fresh = factor(new_[k]);
    if (k < quadratics.size()) {
      fresh.quadratic = tree_.add_quadratic(std::move(quadratics[k]));
    } else {
      stale_.push_back(new_[k]);
    }
  }
  put_tree_to(new_variables());
  new_.clear();
  gain_ = 0.0;
}

template <int Dim>
std::vector<JoinedIndex> IncrementalEstimate<Dim>::new_variables() const {
  std::vector<JoinedIndex> variables;
  for (const FactorIndex f : new_) {
    std::ranges::copy_if(factors_[f].map.variables(), std::back_inserter(variables), [&](JoinedIndex v) {
      return v != kJoinedWorld && variable(v).column != kConstant && !tree_.has(variable(v).column);
    });
  }
  make_distinct(variables);
  return variables;
}

template <int Dim>
Settling IncrementalEstimate<Dim>::settle(std::span<const JoinedIndex> last) {
  std::vector<Variable> last_columns;
  for (const JoinedIndex v : last) {
    if (variable(v).column != kConstant) last_columns.push_back(variable(v).column);
  }
  enter_deferred();
  Settling settling;
  if (looks_ >= factors_.size()) sum_chi2();
  while (!settling.converged && settling.iterations < kMostIterations) {
    linearise_stale();
    settling.eliminated += tree_.update(last_columns, allowance().move());
    ++settling.iterations;
    const double before = chi2_;
    const bool is_taken = take_step(tree_.moved(), tree_.solution(tree_.moved()));
    if (!is_taken) break;
    find_stale();
    const bool is_referred_anew = refer_turned();
    settling.converged = stale_.empty() || (!is_referred_anew && before - chi2_ <= allowance().rounding());
  }
  settled_chi2_ = chi2_;
  settled_free_ = free_;
  settling.moved = shown_.show(variables_);
  return settling;
}

/// Sums chi2 and the errors anew, without the rounding of all that was added and taken away.
template <int Dim>
void IncrementalEstimate<Dim>::sum_chi2() {
  chi2_ = 0.0;
  error_ = 0.0;
  for (const Factor& factor : factors_) {
    chi2_ += factor.fit.chi2;
    error_ += factor.fit.error;
  }
  looks_ = 0;
}

template <int Dim>
void IncrementalEstimate<Dim>::linearise_stale() {
  make_distinct(stale_);
  for (const FactorIndex f : stale_) {
    Factor& stale = factor(f);
    Quadratic system = stale.map.linearise(variables_);
    error_ -= std::exchange(stale.fit.error, 0.0);
    if (stale.quadratic) {
      tree_.change_quadratic(*stale.quadratic, std::move(system.H));
    } else {
      stale.quadratic = tree_.add_quadratic(std::move(system));
    }
  }
  stale_.clear();
}

template <int Dim>
bool IncrementalEstimate<Dim>::errs(const Factor& factor) const {
  return factor.fit.error * static_cast<double>(rows_) > allowance().error() * static_cast<double>(factor.map.rows());
}

/// Takes the maps that err most until the others err by so little that the next map does not ask for it again at once.
template <int Dim>
void IncrementalEstimate<Dim>::find_stale() {
  if (error_ <= allowance().error()) return;
  std::vector<std::pair<double, FactorIndex>> by_error;
  for (const FactorIndex f : indices(factors_)) {
    if (factor(f).fit.error > 0.0) by_error.emplace_back(-factor(f).fit.error, f);
  }
  std::sort(by_error.begin(), by_error.end());
  double left = error_ - kErrorLeft * allowance().error();
  for (auto next = by_error.begin(); next != by_error.end() && left > 0.0; ++next) {
    left += next->first;
    stale_.push_back(next->second);
  }
}

template <int Dim>
bool IncrementalEstimate<Dim>::take_step(const std::vector<Variable>& columns, const Eigen::VectorXd& entries) {
  const double before = chi2_;
  std::vector<JoinedIndex> moved;
  std::vector<PoseVector<Dim>> to;
  Eigen::Index entry = 0;
  for (const Variable column : columns) {
    moved.push_back(variable_of_column_[column]);
    const int dof = variable(moved.back()).dof();
    to.push_back(PoseVector<Dim>::Zero());
    to.back().head(dof) = entries.segment(std::exchange(entry, entry + dof), dof);
  }
  const std::vector<PoseVector<Dim>> from = steps_of(moved);
  move(moved, to);
  if (chi2_ <= before + allowance().rounding()) return true;
  move(moved, from);
  put_tree_to(moved);
  return false;
}

template <int Dim>
void IncrementalEstimate<Dim>::put_tree_to(const std::vector<JoinedIndex>& variables) {
  for (const JoinedIndex v : variables) tree_.set_solution(variable(v).column, variable(v).step.head(variable(v).dof()));
}

template <int Dim>
std::vector<PoseVector<Dim>> IncrementalEstimate<Dim>::steps_of(const std::vector<JoinedIndex>& variables) const {
  std::vector<PoseVector<Dim>> steps;
  for (const JoinedIndex v : variables) steps.push_back(variable(v).step);
  return steps;
}

template <int Dim>
void IncrementalEstimate<Dim>::move(const std::vector<JoinedIndex>& variables, const std::vector<PoseVector<Dim>>& steps) {
  std::vector<FactorIndex> concerned;
  ++moves_;
  for (std::size_t k = 0; k < variables.size(); ++k) {
    JoinedVariable<Dim>& moved = variable(variables[k]);
    shown_.note_moving(variables[k]);
    moved.move_to(steps[k]);
    std::ranges::copy_if(moved.factors, std::back_inserter(concerned),
                         [&](FactorIndex f) { return std::exchange(factor(f).met_in, moves_) != moves_; });
  }
  looks_ += concerned.size();
  for (const FactorIndex f : concerned) {
    const auto fit = factor(f).map.fit(variables_);
    chi2_ += fit.chi2 - factor(f).fit.chi2;
    error_ += fit.error - factor(f).fit.error;
    factor(f).fit = fit;
  }
}

/// Gives poses that have turned far a new reference, in which their maps must be linearised again; true if there are any.
template <int Dim>
bool IncrementalEstimate<Dim>::refer_turned() {
  bool any = false;
  if constexpr (Dim == 3) {
    for (const Variable column : tree_.moved()) {
      JoinedVariable<Dim>& turned = variable(variable_of_column_[column]);
      if (!turned.is_pose || turned.step.template tail<3>().norm() < kMostTurn) continue;
      turned.refer_to_value();
      tree_.set_solution(column, turned.step);
      append(stale_, turned.factors);
      any = true;
    }
  }
  return any;
}

template class IncrementalEstimate<2>;
template class IncrementalEstimate<3>;

}  // namespace mapjoin
