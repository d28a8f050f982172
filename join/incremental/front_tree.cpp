// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <iterator>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/model/lists.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// The share of the rows eliminated by a front and all below it beyond which its update is bulky, and it is eliminated again
/// with the front above: its update, a clique that no order can part, then costs more than it saves (docs/decisions.md).
constexpr double kBulky = 0.5;

}  // namespace

FrontTree::FrontTree() {
  add_variable(1);
  solution_.front() = 1.0;
  add_quadratic({{kOne}, Eigen::MatrixXd::Ones(1, 1)});  // so that there is a root, whose pivot is not 0 where all fits
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
  const QuadraticSum sum = sum_of(opened, {last.begin(), last.end()});
  remove(opened.nodes);  // first, to free their memory
  attach(eliminate(sum), opened);
  return opened.variables.size() - 1;  // kOne is not the caller's
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
  make_distinct(touched_);
  for (const QuadraticIndex q : std::exchange(touched_, {})) {
    open_upwards(quadratics_[q].node, opened);
    if (quadratics_[q].node != kNone || is_removed(q)) continue;
    opened.quadratics.push_back(q);
    for (const Variable v : quadratics_[q].quadratic.variables) {
      open_upwards(node_of(v), opened);
      if (node_of(v) == kNone) variables.push_back(v);
    }
  }
  for (std::size_t k = 0; k < opened.nodes.size(); ++k) take_open(opened.nodes[k], opened);  // which may open others
  variables.push_back(kOne);
  make_distinct(variables);
  return opened;
}

void FrontTree::take_open(NodeIndex n, Opened& opened) {
  append(opened.variables, front(n).frontals);
  std::ranges::copy_if(nodes_[n].quadratics, std::back_inserter(opened.quadratics),
                       [&](QuadraticIndex q) { return !is_removed(q); });
  for (const NodeIndex child : nodes_[n].children) {
    if (nodes_[child].is_open) continue;
    if (is_bulky(child)) {
      nodes_[child].is_open = true;
      opened.nodes.push_back(child);
    } else {
      opened.orphans.push_back(child);
    }
  }
}

bool FrontTree::is_bulky(NodeIndex n) const {
  return static_cast<double>(nodes_[n].update.H.rows()) > kBulky * static_cast<double>(nodes_[n].rows);
}

QuadraticSum FrontTree::sum_of(const Opened& opened, const std::set<Variable>& last) const {
  QuadraticSum sum;
  for (const Variable v : opened.variables) sum.variables.push_back({v, dof(v), last.contains(v) ? 1 : 0});
  sum.variables.front().rank = 2;  // kOne
  for (const QuadraticIndex q : opened.quadratics) sum.quadratics.push_back(&quadratics_[q].quadratic);
  for (const NodeIndex orphan : opened.orphans) sum.quadratics.push_back(&nodes_[orphan].update);
  return sum;
}

void FrontTree::remove(const std::vector<NodeIndex>& nodes) {
  for (const NodeIndex n : nodes) {
    nodes_[n] = Node();
    factor_.nodes.writable(n) = {};
    unused_.push_back(n);
  }
}

void FrontTree::attach(std::vector<SumNode> fresh, const Opened& opened) {
  const std::size_t own = opened.quadratics.size();
  std::vector<NodeIndex> nodes;
  for (const SumNode& node : fresh) {
    if (!node.quadratic) {
      nodes.push_back(new_node());
    } else {
      nodes.push_back(*node.quadratic < own ? kNone : opened.orphans[*node.quadratic - own]);
    }
  }
  for (std::size_t f = 0; f < fresh.size(); ++f) {
    const NodeIndex parent = fresh[f].parent == fresh.size() ? kNone : nodes[fresh[f].parent];
    if (nodes[f] == kNone) {
      const QuadraticIndex q = opened.quadratics[*fresh[f].quadratic];
      quadratics_[q].node = parent;
      nodes_[parent].quadratics.push_back(q);
      continue;
    }
    if (!fresh[f].quadratic) put(nodes[f], std::move(fresh[f]));
    factor_.nodes.writable(nodes[f]).parent = parent;
    if (parent == kNone) continue;
    nodes_[parent].children.push_back(nodes[f]);
    nodes_[parent].rows += nodes_[nodes[f]].rows;
  }
  root_ = nodes.back();
}

void FrontTree::put(NodeIndex n, SumNode eliminated) {
  Front& front = eliminated.front;
  for (const Variable v : front.frontals) factor_.variables.writable(v).node = n;
  if (front.frontals.back() == kOne) {  // the root: kOne is never solved for
    front.frontals.pop_back();
    front.separator.push_back(kOne);
    front.L.conservativeResize(Eigen::NoChange, front.L.cols() - 1);
  }
  nodes_[n].update = std::move(eliminated.update);
  nodes_[n].rows += front.L.cols();
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
  const auto& separator = below.separator;
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
  const Eigen::VectorXd now = next.solved(solution(next.separator));
  const auto L_JJ = next.L.topRows(now.size()).triangularView<Eigen::Lower>();
  // The change in squared standard deviations, with the variables above held.
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
