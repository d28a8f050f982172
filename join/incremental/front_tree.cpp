// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <mapjoin/join/incremental/front_tree.hpp>
#include <mapjoin/solve/sparse_cholesky.hpp>
#include <utility>

namespace mapjoin {
namespace {

/// In squared standard deviations per entry: what moves less stays where it is, and what hangs below is not looked at.
constexpr double kNoMove = 1e-6;

/// Adds what a front leaves of the right-hand side over `rows` to that of its parent: to the parent's own rows in b, to those
/// below it in `below`.
void hand_up(const Eigen::VectorXd& sent, std::span<const std::int64_t> rows, const Supernode& parent, Eigen::VectorXd& b,
             Eigen::VectorXd& below) {
  auto row = parent.rows.begin() + (parent.end - parent.begin);
  const auto first_below = row;
  for (std::size_t k = 0; k < rows.size(); ++k) {
    const double entry = sent[static_cast<Eigen::Index>(k)];
    if (rows[k] < parent.end) {
      b[rows[k]] += entry;
      continue;
    }
    row = std::lower_bound(row, parent.rows.end(), rows[k]);
    below[row - first_below] += entry;
  }
}

}  // namespace

/// Quadratics, and what fronts that stay send up, as the factorisation of what stands above them is given them.
struct FrontTree::Given {
  std::vector<std::vector<Index>> places;  ///< Ascending.
  std::vector<Eigen::MatrixXd> updates;
  std::vector<Eigen::VectorXd> b;
};

Index FrontTree::add_variable(int dof) {
  variables_.push_back({.dof = dof, .offset = static_cast<Eigen::Index>(solution_.size())});
  solution_.resize(solution_.size() + static_cast<std::size_t>(dof), 0.0);
  return static_cast<Index>(variables_.size()) - 1;
}

Index FrontTree::add_quadratic(Quadratic quadratic) {
  const auto q = static_cast<Index>(quadratics_.size());
  for (const Index v : quadratic.variables) variable(v).quadratics.push_back(q);
  quadratics_.push_back(std::move(quadratic));
  touched_.push_back(q);
  return q;
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
  find_summands(opened);
  const NormalEquations equations = pattern_of(opened);
  const Given given = given_by(opened, equations);
  SparseCholesky cholesky(Updates::kKept);
  if (equations.size() > 0) {
    cholesky.analyse(equations.matrix(), given.places);
    cholesky.factorise(equations.matrix(), given.updates);
  }
  rebuild(opened, equations, given, cholesky.supernodes());
  for (const Index v : opened.variables) variable(v).place = kConstant;
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
    for (const Index v : quadratic(q).variables) {
      if (variable(v).node >= 0) {
        open_upwards(variable(v).node, opened);
      } else if (variable(v).place == kConstant) {
        variable(v).place = 0;
        opened.variables.push_back(v);
      }
    }
  }
  touched_.clear();
  for (const Index n : opened.nodes) {
    const Node& open = node(n);
    opened.variables.insert(opened.variables.end(), open.frontals.begin(), open.frontals.end());
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

/// The quadratics of which all variables are eliminated again, and what the orphans send.
void FrontTree::find_summands(Opened& opened) const {
  std::vector<Index> quadratics;
  for (const Index v : opened.variables) {
    for (const Index q : variable(v).quadratics) {
      if (quadratic(q).variables.front() == v) quadratics.push_back(q);
    }
  }
  const auto is_below = [&](Index v) { return variable(v).place == kConstant; };
  for (const Index q : quadratics) {
    const auto& variables = quadratic(q).variables;
    if (std::none_of(variables.begin(), variables.end(), is_below)) opened.summands.push_back(&quadratic(q));
  }
  opened.quadratic_count = opened.summands.size();
  for (const Index orphan : opened.orphans) opened.summands.push_back(&node(orphan).update);
}

NormalEquations FrontTree::pattern_of(const Opened& opened) const {
  std::vector<int> dofs;
  for (const Index v : opened.variables) dofs.push_back(variable(v).dof);
  Cliques cliques;
  for (const Quadratic* summand : opened.summands) {
    std::vector<Index> places;
    for (const Index v : summand->variables) places.push_back(variable(v).place);
    cliques.push_back(places);
  }
  return {std::move(dofs), std::move(cliques), nullptr, {.given = {}, .last_count = opened.last_count}};
}

FrontTree::Given FrontTree::given_by(const Opened& opened, const NormalEquations& equations) const {
  Given given;
  for (const Quadratic* summand : opened.summands) {
    const Quadratic& update = *summand;
    std::vector<std::pair<Index, Eigen::Index>> places;  // each with its first row
    Eigen::Index row = 0;
    for (const Index v : update.variables) {
      places.emplace_back(equations.place(variable(v).place), row);
      row += variable(v).dof;
    }
    std::sort(places.begin(), places.end());
    std::vector<Eigen::Index> rows;
    std::vector<Index>& ascending = given.places.emplace_back();
    for (const auto& [place, first] : places) {
      ascending.push_back(place);
      for (Eigen::Index i = 0; i < equations.matrix().dof(static_cast<std::size_t>(place)); ++i) rows.push_back(first + i);
    }
    const Eigen::MatrixXd H = update.H.selfadjointView<Eigen::Lower>();
    given.updates.emplace_back(H(rows, rows));
    given.b.emplace_back(update.b(rows));
  }
  return given;
}

void FrontTree::rebuild(const Opened& opened, const NormalEquations& equations, const Given& given,
                        const Supernodes& supernodes) {
  std::erase_if(roots_, [&](Index n) { return node(n).is_open; });
  for (const Index n : opened.nodes) {
    node(n) = Node();
    unused_.push_back(n);
  }
  std::vector<Index> variable_at(static_cast<std::size_t>(equations.size()));  // per column
  std::vector<std::size_t> supernode_at(variable_at.size());
  for (std::size_t k = 0; k < opened.variables.size(); ++k) {
    const auto v = static_cast<Index>(k);
    std::fill_n(variable_at.begin() + equations.column_of(v), equations.dof(v), opened.variables[k]);
  }
  std::vector<Index> nodes;
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const Supernode& supernode = supernodes[s];
    std::fill(supernode_at.begin() + supernode.begin, supernode_at.begin() + supernode.end, s);
    const bool is_given = supernode.begin == supernode.end;
    const bool is_quadratic = is_given && supernode.given < opened.quadratic_count;
    nodes.push_back(is_quadratic ? -1 : is_given ? opened.orphans[supernode.given - opened.quadratic_count] : new_node());
    if (!is_given) take(nodes.back(), supernode, variable_at);
  }
  link(nodes, supernodes, supernode_at, given.b);
}

/// Makes nodes each other's parents and children, and takes the right-hand sides up the tree.
void FrontTree::link(const std::vector<Index>& nodes, const Supernodes& supernodes,
                     const std::vector<std::size_t>& supernode_at, const std::vector<Eigen::VectorXd>& given) {
  Eigen::VectorXd b = Eigen::VectorXd::Zero(static_cast<Eigen::Index>(supernode_at.size()));
  for (std::size_t s = 0; s < supernodes.size(); ++s) {
    const Supernode& supernode = supernodes[s];
    const Eigen::Index width = supernode.end - supernode.begin;
    if (width > 0) {
      Node& of = node(nodes[s]);
      of.y = of.L.topRows(width).triangularView<Eigen::Lower>().solve(b.segment(supernode.begin, width));
      of.update.b.noalias() -= of.L.bottomRows(of.update.b.size()) * of.y;
    }
    const auto first_below = supernode.rows.begin() + width;
    const bool is_root = first_below == supernode.rows.end();
    const std::size_t p = is_root ? 0 : supernode_at[static_cast<std::size_t>(*first_below)];
    if (nodes[s] >= 0) {
      node(nodes[s]).parent = is_root ? -1 : nodes[p];
      (is_root ? roots_ : node(nodes[p]).children).push_back(nodes[s]);
    }
    if (is_root) continue;
    const Eigen::VectorXd& sent = width > 0 ? node(nodes[s]).update.b : given[supernode.given];
    hand_up(sent, {first_below, supernode.rows.end()}, supernodes[p], b, node(nodes[p]).update.b);
  }
}

void FrontTree::take(Index n, const Supernode& supernode, const std::vector<Index>& variable_at) {
  Node& fresh = node(n);
  const Eigen::Index width = supernode.end - supernode.begin;
  const auto height = static_cast<Eigen::Index>(supernode.rows.size());
  for (Eigen::Index row = 0; row < height;) {
    const Index v = variable_at[static_cast<std::size_t>(supernode.rows[static_cast<std::size_t>(row)])];
    (row < width ? fresh.frontals : fresh.update.variables).push_back(v);
    if (row < width) variable(v).node = n;
    row += variable(v).dof;
  }
  fresh.L = Eigen::Map<const Eigen::MatrixXd>(supernode.values, height, width);
  fresh.update.H = Eigen::Map<const Eigen::MatrixXd>(supernode.update, height - width, height - width);
  fresh.update.b.setZero(height - width);
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

void FrontTree::solve() {
  moved_.clear();
  std::vector<Index> to_visit = roots_;
  while (!to_visit.empty()) {
    Node& next = node(to_visit.back());
    to_visit.pop_back();
    if (!is_displaced_ && !next.is_fresh && !is_above_moved(next)) continue;
    next.is_fresh = false;
    solve_node(next);
    to_visit.insert(to_visit.end(), next.children.begin(), next.children.end());
  }
  is_displaced_ = false;
}

bool FrontTree::is_above_moved(const Node& below) const {
  const auto& separator = below.update.variables;
  return std::any_of(separator.begin(), separator.end(), [&](Index v) { return variable(v).moved_in == updates_; });
}

Eigen::VectorXd FrontTree::gathered(const std::vector<Index>& variables, Eigen::Index size) const {
  Eigen::VectorXd entries(size);
  Eigen::Index entry = 0;
  for (const Index v : variables) {
    entries.segment(entry, variable(v).dof) = solution(v);
    entry += variable(v).dof;
  }
  return entries;
}

void FrontTree::solve_node(const Node& next) {
  const Eigen::Index width = next.L.cols();
  const auto L_JJ = next.L.topRows(width).triangularView<Eigen::Lower>();
  const Eigen::VectorXd above = gathered(next.update.variables, next.L.rows() - width);
  Eigen::VectorXd now = next.y;
  now.noalias() -= next.L.bottomRows(above.size()).transpose() * above;
  L_JJ.transpose().solveInPlace(now);
  // The change in squared standard deviations, what lies above being held.
  const double change = (L_JJ.transpose() * (now - gathered(next.frontals, width))).squaredNorm();
  if (change <= kNoMove * static_cast<double>(width)) return;
  Eigen::Index entry = 0;
  for (const Index v : next.frontals) {
    std::copy_n(now.data() + entry, variable(v).dof, solution_.begin() + variable(v).offset);
    entry += variable(v).dof;
    variable(v).moved_in = updates_;
    moved_.push_back(v);
  }
}

}  // namespace mapjoin
