// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <deque>
#include <iterator>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// A quadratic over these columns, one for each of its variables; `storage` keeps what had to be put in another order.
GivenFront given_front(const Eigen::MatrixXd& H, const std::vector<Column>& columns, const BlockLower& matrix,
                       std::deque<Eigen::MatrixXd>& storage) {
  GivenFront front{columns, {H.data(), H.rows(), H.cols(), Eigen::OuterStride<>(H.rows())}};
  if (std::is_sorted(columns.begin(), columns.end())) return front;
  std::vector<std::pair<Column, Eigen::Index>> blocks;  // each with its first row
  Eigen::Index row = 0;
  for (const Column column : columns) blocks.emplace_back(column, std::exchange(row, row + matrix.dof(column)));
  std::sort(blocks.begin(), blocks.end());
  std::sort(front.rows.begin(), front.rows.end());
  std::vector<Eigen::Index> rows;
  for (const auto& [column, first] : blocks) {
    for (Eigen::Index i = 0; i < matrix.dof(column); ++i) rows.push_back(first + i);
  }
  const Eigen::MatrixXd full = H.selfadjointView<Eigen::Lower>();
  const Eigen::MatrixXd& sorted = storage.emplace_back(full(rows, rows));
  return {std::move(front.rows), {sorted.data(), row, row, Eigen::OuterStride<>(row)}};
}

}  // namespace

FrontTree::FrontTree() {
  add_variable(1);
  solution_.front() = 1.0;
  add_quadratic({{kOne}, Eigen::MatrixXd::Ones(1, 1)});  // whatever others there are, its pivot is at least 1
}

Variable FrontTree::add_variable(int dof) {
  const Variable added(variables_.size());
  factor_.variables.push_back({.dof = dof});
  variables_.push_back({.offset = static_cast<Eigen::Index>(solution_.size())});
  solution_.resize(solution_.size() + static_cast<std::size_t>(dof), 0.0);
  return added;
}

FrontTree::QuadraticIndex FrontTree::add_quadratic(Quadratic quadratic) {
  quadratics_.push_back({std::move(quadratic)});
  touched_.emplace_back(quadratics_.size() - 1);
  return touched_.back();
}

void FrontTree::change_quadratic(QuadraticIndex q, Eigen::MatrixXd H) {
  quadratics_[q].quadratic.H = std::move(H);
  touched_.push_back(q);
}

void FrontTree::remove_quadratic(QuadraticIndex q) {
  quadratics_[q].quadratic = {};
  std::erase(touched_, q);
  if (quadratics_[q].node != kNone) touched_.push_back(q);
}

Eigen::Map<const Eigen::VectorXd> FrontTree::solution(Variable v) const {
  return {solution_.data() + variables_[v].offset, dof(v)};
}

void FrontTree::set_solution(Variable v, const Eigen::Ref<const Eigen::VectorXd>& entries) {
  std::copy(entries.begin(), entries.end(), solution_.begin() + variables_[v].offset);
  is_displaced_ |= has(v);
}

std::size_t FrontTree::update(std::span<const Variable> last, double no_move) {
  ++updates_;
  const std::size_t eliminated = touched_.empty() ? 0 : eliminate_touched(last);
  solve(no_move);
  return eliminated;
}

std::size_t FrontTree::eliminate_touched(std::span<const Variable> last) {
  const Opened opened = open_touched();
  const std::vector<const Quadratic*> summands = this->summands(opened);
  const Elimination elimination = planned(opened, summands, last);
  std::deque<Eigen::MatrixXd> storage;
  std::vector<GivenFront> given;
  for (const Quadratic* summand : summands) {
    std::vector<Column> columns;
    for (const Variable v : summand->variables) columns.push_back(elimination.column[variables_[v].place]);
    given.push_back(given_front(summand->H, columns, elimination.matrix, storage));
  }
  SparseCholesky cholesky(Updates::kKept);
  cholesky.analyse(elimination.matrix, given);
  const auto singular = cholesky.factorise(elimination.matrix, given);
  replace(opened, elimination, cholesky, singular);
  for (const Variable v : opened.variables) variables_[v].place = kConstant;
  return opened.variables.size() - 1;  // kOne is none of the caller's
}

void FrontTree::open_upwards(NodeIndex n, Opened& opened) {
  for (; n != kNone && !nodes_[n].is_open; n = parent(n)) {
    nodes_[n].is_open = true;
    opened.nodes.push_back(n);
  }
}

FrontTree::Opened FrontTree::open_touched() {
  Opened opened;
  auto& variables = opened.variables;
  std::sort(touched_.begin(), touched_.end());
  touched_.erase(std::unique(touched_.begin(), touched_.end()), touched_.end());
  for (const QuadraticIndex q : std::exchange(touched_, {})) {
    open_upwards(quadratics_[q].node, opened);
    if (quadratics_[q].node != kNone || is_removed(q)) continue;
    opened.quadratics.push_back(q);
    for (const Variable v : quadratics_[q].quadratic.variables) {
      open_upwards(node_of(v), opened);
      if (node_of(v) == kNone) variables.push_back(v);
    }
  }
  for (const NodeIndex n : opened.nodes) {
    const Node& open = nodes_[n];
    const auto& frontals = front(n).frontals;
    variables.insert(variables.end(), frontals.begin(), frontals.end());
    std::copy_if(open.quadratics.begin(), open.quadratics.end(), std::back_inserter(opened.quadratics),
                 [&](QuadraticIndex q) { return !is_removed(q); });
    for (const NodeIndex child : open.children) {
      if (!nodes_[child].is_open) opened.orphans.push_back(child);
    }
  }
  variables.push_back(kOne);
  std::sort(variables.begin(), variables.end());
  variables.erase(std::unique(variables.begin(), variables.end()), variables.end());
  for (const Variable place : indices(variables)) variables_[variables[place]].place = place;
  return opened;
}

std::vector<const Quadratic*> FrontTree::summands(const Opened& opened) const {
  std::vector<const Quadratic*> summands;
  for (const QuadraticIndex q : opened.quadratics) summands.push_back(&quadratics_[q].quadratic);
  for (const NodeIndex orphan : opened.orphans) summands.push_back(&front(orphan).update);
  return summands;
}

Elimination FrontTree::planned(const Opened& opened, const std::vector<const Quadratic*>& summands,
                               std::span<const Variable> last) const {
  BlockPattern pattern;
  for (const Variable v : opened.variables) pattern.dofs.push_back(dof(v));
  for (const Quadratic* summand : summands) {
    std::vector<Variable> places;
    for (const Variable v : summand->variables) places.push_back(variables_[v].place);
    pattern.factors.push_back(places);
  }
  Ordering ordering;
  ordering.ranks.assign(opened.variables.size(), 0);
  for (const Variable v : last) {
    if (variables_[v].place != kConstant) ordering.ranks[variables_[v].place] = 1;
  }
  ordering.ranks[variables_[kOne].place] = 2;
  return Elimination(pattern, ordering);
}

void FrontTree::replace(const Opened& opened, const Elimination& elimination, SparseCholesky& cholesky,
                        std::span<const std::int64_t> singular) {
  for (const NodeIndex n : opened.nodes) {
    nodes_[n] = Node();
    factor_.nodes.writable(n) = {};
    unused_.push_back(n);
  }
  const std::size_t quadratic_count = opened.quadratics.size();
  const auto& fronts = cholesky.tree().nodes;
  std::vector<NodeIndex> nodes;
  for (const FactorNode& front : fronts) {
    const bool is_quadratic = front.width == 0 && front.given < quadratic_count;
    nodes.push_back(front.width > 0 ? new_node() : is_quadratic ? kNone : opened.orphans[front.given - quadratic_count]);
  }
  auto next_singular = singular.begin();
  for (std::size_t f = 0; f < fronts.size(); ++f) {
    const NodeIndex parent = fronts[f].parent == fronts.size() ? kNone : nodes[fronts[f].parent];
    if (nodes[f] == kNone) {
      const QuadraticIndex q = opened.quadratics[fronts[f].given];
      quadratics_[q].node = parent;
      nodes_[parent].quadratics.push_back(q);
      continue;
    }
    if (fronts[f].width > 0) {
      Front front = taken(opened, elimination, cholesky, f);
      const std::int64_t end = elimination.matrix.offsets[fronts[f].columns.last];
      for (; next_singular != singular.end() && *next_singular < end; ++next_singular) front.is_singular = true;
      put(nodes[f], std::move(front));
    }
    factor_.nodes.writable(nodes[f]).parent = parent;
    if (parent != kNone) nodes_[parent].children.push_back(nodes[f]);
  }
  root_ = nodes.back();
}

Front FrontTree::taken(const Opened& opened, const Elimination& elimination, SparseCholesky& cholesky, std::size_t f) const {
  Front fresh;
  const FactorNode& front = cholesky.tree().nodes[f];
  const auto variable_at = [&](Column column) { return opened.variables[elimination.order[column]]; };
  for (const Column column : front.columns) fresh.frontals.push_back(variable_at(column));
  for (const Column row : cholesky.tree().rows_of(front)) fresh.update.variables.push_back(variable_at(row));
  fresh.L = cholesky.panel(front);
  fresh.update.H = cholesky.take_update(f);
  return fresh;
}

void FrontTree::put(NodeIndex n, Front front) {
  for (const Variable v : front.frontals) factor_.variables.writable(v).node = n;
  if (front.frontals.back() == kOne) {  // the root: kOne is never solved for
    front.frontals.pop_back();
    front.update.variables.push_back(kOne);
    front.L = Eigen::MatrixXd(front.L.leftCols(front.L.cols() - 1));
  }
  nodes_[n].is_fresh = true;
  factor_.nodes.writable(n).front = std::make_shared<const Front>(std::move(front));
}

FrontTree::NodeIndex FrontTree::new_node() {
  if (unused_.empty()) {
    nodes_.emplace_back();
    return factor_.nodes.push_back({});
  }
  const NodeIndex n = unused_.back();
  unused_.pop_back();
  return n;
}

void FrontTree::solve(double no_move) {
  moved_.clear();
  std::vector<NodeIndex> to_visit{root_};
  while (!to_visit.empty()) {
    const NodeIndex n = to_visit.back();
    Node& next = nodes_[n];
    to_visit.pop_back();
    if (!is_displaced_ && !next.is_fresh && !is_above_moved(front(n))) continue;
    next.is_fresh = false;
    solve_front(front(n), no_move);
    to_visit.insert(to_visit.end(), next.children.begin(), next.children.end());
  }
  is_displaced_ = false;
}

bool FrontTree::is_above_moved(const Front& below) const {
  const auto& separator = below.update.variables;
  return std::any_of(separator.begin(), separator.end(), [&](Variable v) { return variables_[v].moved_in == updates_; });
}

Eigen::VectorXd FrontTree::solution(const std::vector<Variable>& variables) const {
  Eigen::Index size = 0;
  for (const Variable v : variables) size += dof(v);
  Eigen::VectorXd entries(size);
  size = 0;
  for (const Variable v : variables) {
    entries.segment(size, dof(v)) = solution(v);
    size += dof(v);
  }
  return entries;
}

void FrontTree::solve_front(const Front& next, double no_move) {
  const Eigen::VectorXd now = next.solved(solution(next.update.variables));
  const auto L_JJ = next.L.topRows(now.size()).triangularView<Eigen::Lower>();
  // The change in squared standard deviations, what lies above being held.
  const double change = (L_JJ.transpose() * (now - solution(next.frontals))).squaredNorm();
  if (change <= no_move * static_cast<double>(now.size())) return;
  Eigen::Index entry = 0;
  for (const Variable v : next.frontals) {
    std::copy_n(now.data() + entry, dof(v), solution_.begin() + variables_[v].offset);
    entry += dof(v);
    variables_[v].moved_in = updates_;
    moved_.push_back(v);
  }
}

}  // namespace mapjoin
