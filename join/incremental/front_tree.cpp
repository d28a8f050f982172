// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// In squared standard deviations per entry: what moves less stays where it is, and what hangs below is not looked at.
constexpr double kNoMove = 1e-6;

}  // namespace

/// What is eliminated again.
struct FrontTree::Opened {
  std::vector<Index> nodes;
  std::vector<Index> variables;   // those to be eliminated last at the end
  std::vector<Index> quadratics;  // of the open nodes, and the new ones
  std::vector<Index> orphans;     // nodes below the open ones
  Index last_count = 0;
};

Index FrontTree::add_variable(int dof) {
  variables_.push_back({.dof = dof, .offset = static_cast<Eigen::Index>(solution_.size())});
  solution_.resize(solution_.size() + static_cast<std::size_t>(dof), 0.0);
  return static_cast<Index>(variables_.size()) - 1;
}

Index FrontTree::add_quadratic(Quadratic quadratic) {
  quadratics_.push_back(std::move(quadratic));
  node_of_.push_back(-1);
  touched_.push_back(static_cast<Index>(quadratics_.size()) - 1);
  return touched_.back();
}

void FrontTree::change_quadratic(Index q, Eigen::MatrixXd H, Eigen::VectorXd b) {
  quadratic(q).H = std::move(H);
  quadratic(q).b = std::move(b);
  touched_.push_back(q);
}

Eigen::Map<const Eigen::VectorXd> FrontTree::solution(Index v) const {
  return {solution_.data() + variable(v).offset, variable(v).dof};
}

void FrontTree::set_solution(Index v, const Eigen::Ref<const Eigen::VectorXd>& entries) {
  std::copy(entries.begin(), entries.end(), solution_.begin() + variable(v).offset);
  is_displaced_ = true;
}

std::size_t FrontTree::update(std::span<const Index> last) {
  ++updates_;
  Opened opened = open_touched();
  order(last, opened);
  const FrontPlan planned = plan(opened);
  const std::vector<Index> nodes = rebuild(opened, planned);
  for (std::size_t k = nodes.size(); k-- > 0;) eliminate(opened, planned.fronts[k], nodes[k]);
  for (const Index v : opened.variables) variable(v).place = -1;
  solve();
  return opened.variables.size();
}

void FrontTree::open_upwards(Index n, Opened& opened) {
  for (; n >= 0 && !node(n).is_open; n = node(n).parent) {
    node(n).is_open = true;
    opened.nodes.push_back(n);
  }
}

FrontTree::Opened FrontTree::open_touched() {
  Opened opened;
  for (const Index q : touched_) {
    const Index n = node_of_[static_cast<std::size_t>(q)];
    if (n >= 0) {
      open_upwards(n, opened);
      continue;
    }
    opened.quadratics.push_back(q);
    for (const Index v : quadratic(q).variables) {
      if (variable(v).node >= 0) {
        open_upwards(variable(v).node, opened);
      } else if (variable(v).place < 0) {
        variable(v).place = 0;
        opened.variables.push_back(v);
      }
    }
  }
  touched_.clear();
  for (const Index n : opened.nodes) {
    const Node& open = node(n);
    opened.variables.insert(opened.variables.end(), open.front.frontals().begin(), open.front.frontals().end());
    opened.quadratics.insert(opened.quadratics.end(), open.quadratics.begin(), open.quadratics.end());
    for (const Index child : open.children) {
      if (!node(child).is_open) opened.orphans.push_back(child);
    }
  }
  return opened;
}

/// Those in `last` behind the others, ascending both; sets their places.
void FrontTree::order(std::span<const Index> last, Opened& opened) {
  auto& variables = opened.variables;
  std::sort(variables.begin(), variables.end());
  std::vector<Index> late(last.begin(), last.end());
  std::sort(late.begin(), late.end());
  const auto is_early = [&](Index v) { return !std::binary_search(late.begin(), late.end(), v); };
  const auto first_late = std::stable_partition(variables.begin(), variables.end(), is_early);
  opened.last_count = static_cast<Index>(variables.end() - first_late);
  for (std::size_t k = 0; k < variables.size(); ++k) variable(variables[k]).place = static_cast<Index>(k);
}

FrontPlan FrontTree::plan(const Opened& opened) const {
  std::vector<int> dofs;
  for (const Index v : opened.variables) dofs.push_back(variable(v).dof);
  Cliques cliques;
  std::vector<Index> places;
  const auto add_clique = [&](const std::vector<Index>& variables) {
    places.clear();
    for (const Index v : variables) places.push_back(variable(v).place);
    cliques.push_back(places);
  };
  for (const Index q : opened.quadratics) add_clique(quadratic(q).variables);
  for (const Index orphan : opened.orphans) add_clique(node(orphan).front.message().variables);
  return plan_fronts(dofs, cliques, opened.last_count);
}

std::vector<Index> FrontTree::rebuild(const Opened& opened, const FrontPlan& plan) {
  std::erase_if(roots_, [&](Index n) { return node(n).is_open; });
  for (const Index n : opened.nodes) {
    node(n) = Node();
    unused_.push_back(n);
  }
  std::vector<Index> nodes;
  for (const PlannedFront& planned : plan.fronts) {
    const Index n = new_node();
    nodes.push_back(n);
    node(n).parent = planned.parent < 0 ? -1 : nodes[static_cast<std::size_t>(planned.parent)];
    (planned.parent < 0 ? roots_ : node(node(n).parent).children).push_back(n);
  }
  auto front = plan.front_of_clique.begin();
  for (const Index q : opened.quadratics) {
    const Index n = nodes[static_cast<std::size_t>(*front++)];
    node(n).quadratics.push_back(q);
    node_of_[static_cast<std::size_t>(q)] = n;
  }
  for (const Index orphan : opened.orphans) {
    const Index n = nodes[static_cast<std::size_t>(*front++)];
    node(n).children.push_back(orphan);
    node(orphan).parent = n;
  }
  return nodes;
}

void FrontTree::eliminate(const Opened& opened, const PlannedFront& planned, Index n) {
  std::vector<Index> variables;
  Eigen::Index frontal_size = 0;
  for (const Index place : planned.frontals) {
    variables.push_back(opened.variables[static_cast<std::size_t>(place)]);
    variable(variables.back()).node = n;
    frontal_size += variable(variables.back()).dof;
  }
  for (const Index place : planned.separator) variables.push_back(opened.variables[static_cast<std::size_t>(place)]);
  Node& fresh = node(n);
  fresh.front = Front(assembled(fresh, std::move(variables)), planned.frontals.size(), frontal_size);
  fresh.is_fresh = true;
}

Index FrontTree::new_node() {
  if (unused_.empty()) {
    nodes_.emplace_back();
    return static_cast<Index>(nodes_.size()) - 1;
  }
  const Index n = unused_.back();
  unused_.pop_back();
  return n;
}

Quadratic FrontTree::assembled(const Node& of, std::vector<Index> variables) {
  Eigen::Index rows = 0;
  for (const Index v : variables) {
    variable(v).row = rows;
    rows += variable(v).dof;
  }
  Quadratic sum{std::move(variables), Eigen::MatrixXd::Zero(rows, rows), Eigen::VectorXd::Zero(rows)};
  for (const Index q : of.quadratics) add_to(sum, quadratic(q));
  for (const Index child : of.children) add_to(sum, node(child).front.message());
  return sum;
}

void FrontTree::add_to(Quadratic& sum, const Quadratic& part) {
  std::vector<Eigen::Index> rows;
  for (const Index v : part.variables) {
    for (int i = 0; i < variable(v).dof; ++i) rows.push_back(variable(v).row + i);
  }
  const auto size = static_cast<Eigen::Index>(rows.size());
  for (Eigen::Index c = 0; c < size; ++c) {
    const Eigen::Index column = rows[static_cast<std::size_t>(c)];
    sum.b[column] += part.b[c];
    for (Eigen::Index r = c; r < size; ++r) {
      const Eigen::Index row = rows[static_cast<std::size_t>(r)];
      sum.H(std::max(row, column), std::min(row, column)) += part.H(r, c);
    }
  }
}

void FrontTree::solve() {
  moved_.clear();
  std::vector<Index> to_visit = roots_;
  while (!to_visit.empty()) {
    Node& next = node(to_visit.back());
    to_visit.pop_back();
    if (!is_displaced_ && !next.is_fresh && !is_above_moved(next)) continue;
    next.is_fresh = false;
    solve_front(next.front);
    to_visit.insert(to_visit.end(), next.children.begin(), next.children.end());
  }
  is_displaced_ = false;
}

bool FrontTree::is_above_moved(const Node& below) const {
  const auto& separator = below.front.message().variables;
  return std::any_of(separator.begin(), separator.end(), [&](Index v) { return variable(v).moved_in == updates_; });
}

void FrontTree::solve_front(const Front& front) {
  const auto gathered = [&](const std::vector<Index>& variables) {
    Eigen::Index size = 0;
    for (const Index v : variables) size += variable(v).dof;
    Eigen::VectorXd entries(size);
    Eigen::Index entry = 0;
    for (const Index v : variables) {
      entries.segment(entry, variable(v).dof) = solution(v);
      entry += variable(v).dof;
    }
    return entries;
  };
  const Eigen::VectorXd before = gathered(front.frontals());
  const Eigen::VectorXd now = front.solve(gathered(front.message().variables));
  if (front.squared_deviations(now - before) <= kNoMove * static_cast<double>(now.size())) return;
  Eigen::Index entry = 0;
  for (const Index v : front.frontals()) {
    std::copy_n(now.data() + entry, variable(v).dof, solution_.begin() + variable(v).offset);
    entry += variable(v).dof;
    variable(v).moved_in = updates_;
    moved_.push_back(v);
  }
}

}  // namespace mapjoin
