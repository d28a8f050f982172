// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <cmath>
#include <mapjoin/join/incremental/incremental_estimate.hpp>

namespace mapjoin {
namespace {

constexpr int kMostIterations = 50;
constexpr int kMostHalvings = 10;
/// Of a linearisation, in chi2 per measured row: 0.3 % of a standard deviation.
constexpr double kLinearisationError = 1e-5;
/// By so much chi2 may rise where linearisations err by as much as they may.
constexpr double kLittleChi2 = 1e-3;
/// Beyond this turn (rad) since its reference a pose gets a new one: rotation vectors are good up to π.
constexpr double kMostTurn = 1.0;

}  // namespace

template <int Dim>
Index IncrementalEstimate<Dim>::add_variable(bool is_pose, Index index, const Pose<Dim>& value, bool is_held) {
  JoinedVariable<Dim>& added = variables_.emplace_back();
  added.is_pose = is_pose;
  added.index = index;
  added.reference = added.value = value;
  is_remembered_.push_back(false);
  const auto v = static_cast<Index>(variables_.size()) - 1;
  if (is_held) return v;
  added.column = tree_.add_variable(added.dof());
  variable_of_column_.push_back(v);
  free_ += added.dof();
  return v;
}

template <int Dim>
void IncrementalEstimate<Dim>::place(Index v, const Pose<Dim>& value) {
  variable(v).reference = variable(v).value = value;
}

template <int Dim>
void IncrementalEstimate<Dim>::add_factor(MapFactor<Dim> map) {
  const auto f = static_cast<Index>(factors_.size());
  for (const Index v : map.slots()) {
    if (v != kWorld) variable(v).factors.push_back(f);
  }
  rows_ += map.rows();
  Factor& added = factors_.emplace_back(Factor{std::move(map), -1, {}, 0});
  added.fit.chi2 = added.map.chi2(variables_);
  chi2_ += added.fit.chi2;
  stale_.push_back(f);
}

template <int Dim>
Settling IncrementalEstimate<Dim>::settle(std::span<const Index> last) {
  std::vector<Index> last_columns;
  for (const Index v : last) {
    if (variable(v).column != kConstant) last_columns.push_back(variable(v).column);
  }
  Settling settling;
  while (!settling.converged && settling.iterations < kMostIterations) {
    linearise_stale();
    settling.eliminated += tree_.update(last_columns);
    ++settling.iterations;
    const std::vector<Move> step = moves();
    remember(step);
    const double share = take(step);
    if (share == 0.0) break;
    refer_turned(step);
    settling.converged = share == 1.0 && stale_.empty();
  }
  settling.moved = take_moved();
  known_ = variables_.size();
  return settling;
}

template <int Dim>
void IncrementalEstimate<Dim>::linearise_stale() {
  for (const Index f : stale_) {
    Factor& stale = factor(f);
    Quadratic system = stale.map.linearise(variables_);
    if (stale.quadratic < 0) {
      stale.quadratic = tree_.add_quadratic(std::move(system));
    } else {
      tree_.change_quadratic(stale.quadratic, std::move(system.H), std::move(system.b));
    }
  }
  stale_.clear();
}

template <int Dim>
std::vector<typename IncrementalEstimate<Dim>::Move> IncrementalEstimate<Dim>::moves() const {
  std::vector<Move> moves;
  for (const Index column : tree_.moved()) {
    const Index v = variable_of_column_[static_cast<std::size_t>(column)];
    const JoinedVariable<Dim>& moving = variables_[static_cast<std::size_t>(v)];
    Move move{v, moving.step, PoseVector<Dim>::Zero()};
    move.to.head(moving.dof()) = tree_.solution(column);
    moves.push_back(move);
  }
  return moves;
}

template <int Dim>
double IncrementalEstimate<Dim>::take(const std::vector<Move>& moves) {
  const double before = chi2_;
  double share = 1.0;
  for (int halvings = 0; halvings <= kMostHalvings; ++halvings, share *= 0.5) {
    const std::vector<Index> concerned = apply(moves, share);
    if (!(chi2_ <= before + kLittleChi2)) continue;
    for (const Index f : concerned) {
      const bool is_stale =
          share < 1.0 || factor(f).fit.error > kLinearisationError * static_cast<double>(factor(f).map.rows());
      if (is_stale) stale_.push_back(f);
    }
    if (share == 1.0) return share;
    for (const Move& move : moves) {
      const JoinedVariable<Dim>& moved = variable(move.variable);
      tree_.set_solution(moved.column, moved.step.head(moved.dof()));
    }
    return share;
  }
  apply(moves, 0.0);
  for (const Move& move : moves) {
    const JoinedVariable<Dim>& moved = variable(move.variable);
    tree_.set_solution(moved.column, moved.step.head(moved.dof()));
  }
  return 0.0;
}

template <int Dim>
std::vector<Index> IncrementalEstimate<Dim>::apply(const std::vector<Move>& moves, double share) {
  ++steps_;
  std::vector<Index> concerned;
  for (const Move& move : moves) {
    variable(move.variable).move_to(move.from + share * (move.to - move.from));
    for (const Index f : variable(move.variable).factors) {
      if (factor(f).met_in == steps_) continue;
      factor(f).met_in = steps_;
      concerned.push_back(f);
    }
  }
  for (const Index f : concerned) {
    const auto fit = factor(f).map.fit(variables_);
    chi2_ += fit.chi2 - factor(f).fit.chi2;
    factor(f).fit = fit;
  }
  return concerned;
}

/// A pose that has turned far gets a new reference; what it concerns is linearised again.
template <int Dim>
void IncrementalEstimate<Dim>::refer_turned(const std::vector<Move>& moves) {
  if constexpr (Dim == 3) {
    bool any = false;
    for (const Move& move : moves) {
      JoinedVariable<Dim>& turned = variable(move.variable);
      if (!turned.is_pose || turned.step.template tail<3>().norm() < kMostTurn) continue;
      any = true;
      turned.refer_to_value();
      tree_.set_solution(turned.column, turned.step);
      stale_.insert(stale_.end(), turned.factors.begin(), turned.factors.end());
    }
    if (!any) return;
    std::sort(stale_.begin(), stale_.end());
    stale_.erase(std::unique(stale_.begin(), stale_.end()), stale_.end());
  }
}

template <int Dim>
void IncrementalEstimate<Dim>::remember(const std::vector<Move>& moves) {
  for (const Move& move : moves) {
    const auto v = static_cast<std::size_t>(move.variable);
    if (v >= known_ || is_remembered_[v]) continue;
    is_remembered_[v] = true;
    before_.emplace_back(move.variable, variables_[v].value);
  }
}

/// How far those have gone that are remembered, which are then forgotten.
template <int Dim>
StepSize IncrementalEstimate<Dim>::take_moved() {
  StepSize size;
  for (const auto& [v, was] : before_) {
    const JoinedVariable<Dim>& is = variable(v);
    const PoseVector<Dim> step = local(was, is.value);
    size.metres = std::max(size.metres, step.template head<Dim>().norm());
    if (is.is_pose) size.radians = std::max(size.radians, step.template tail<kRotationDof<Dim>>().norm());
    is_remembered_[static_cast<std::size_t>(v)] = false;
  }
  before_.clear();
  return size;
}

template class IncrementalEstimate<2>;
template class IncrementalEstimate<3>;

}  // namespace mapjoin
