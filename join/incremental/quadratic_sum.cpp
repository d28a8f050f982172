// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <map>
#include <mapjoin/join/incremental/quadratic_sum.hpp>
#include <mapjoin/model/lists.hpp>
#include <mapjoin/solve/block_pattern.hpp>
#include <mapjoin/solve/engines/sparse_cholesky.hpp>
#include <numeric>
#include <span>
#include <tuple>
#include <utility>

namespace mapjoin {
namespace {

/// The variables of a sum in blocks: those of one rank that are in the same quadratics, and so have the same neighbours.
/// Eliminated one after the other they fill in no more than the first does, so that Elimination takes a block as one variable:
/// a Variable named `block` is its number. A place is that of a variable in the sum.
class Blocks {
 public:
  explicit Blocks(const QuadraticSum& sum) : sum_(sum), block_of_(sum.variables.size()) {
    std::vector<std::vector<std::size_t>> quadratics_of(sum.variables.size());
    for (std::size_t q = 0; q < sum.quadratics.size(); ++q) {
      std::vector<std::size_t> places;
      for (const Variable v : sum.quadratics[q]->variables) {
        places.push_back(place(v));
        quadratics_of[places.back()].push_back(q);
      }
      places_.push_back(places);
    }
    std::map<std::pair<int, std::vector<std::size_t>>, std::vector<std::size_t>> alike;
    for (std::size_t p = 0; p < quadratics_of.size(); ++p) {
      if (quadratics_of[p].empty()) {
        add_block({p});  // coupled to nothing
      } else {
        alike[{sum.variables[p].rank, std::move(quadratics_of[p])}].push_back(p);
      }
    }
    for (const auto& [key, members] : alike) add_block(members);
  }

  /// The places of a quadratic's variables.
  std::span<const std::size_t> places(std::size_t quadratic) const { return places_[quadratic]; }
  Variable block_of(std::size_t place) const { return block_of_[place]; }
  int dof(std::size_t place) const { return sum_.variables[place].dof; }
  /// The variables of a block, ascending.
  std::vector<Variable> members(Variable block) const {
    std::vector<Variable> members;
    for (const std::size_t p : members_[block]) members.push_back(sum_.variables[p].variable);
    return members;
  }

  Elimination planned() const {
    BlockPattern pattern;
    Ordering ordering;
    for (Variable block(0); block.position() < members_.size(); ++block) {
      const auto members = members_[block];
      pattern.dofs.push_back(
          std::accumulate(members.begin(), members.end(), 0, [&](int sum, std::size_t p) { return sum + dof(p); }));
      ordering.ranks.push_back(sum_.variables[members.front()].rank);
    }
    ordering.weights = pattern.dofs;
    for (std::size_t q = 0; q < places_.size(); ++q) {
      std::vector<Variable> blocks;
      for (const std::size_t p : places_[q]) blocks.push_back(block_of(p));
      make_distinct(blocks);
      pattern.factors.push_back(blocks);
    }
    return Elimination(pattern, ordering);
  }

 private:
  std::size_t place(Variable v) const {
    const auto found = std::ranges::lower_bound(sum_.variables, v, {}, &QuadraticSum::Unknown::variable);
    return static_cast<std::size_t>(found - sum_.variables.begin());
  }
  void add_block(const std::vector<std::size_t>& members) {
    for (const std::size_t p : members) block_of_[p] = Variable(members_.size());
    members_.push_back(members);
  }

  const QuadraticSum& sum_;
  Lists<std::size_t, std::size_t> places_;  // of each quadratic's variables
  Lists<Variable, std::size_t> members_;    // places of each block
  std::vector<Variable> block_of_;          // by place
};

/// A quadratic over columns of blocks.
GivenFront given_front(const Quadratic& quadratic, std::span<const std::size_t> places, const Blocks& blocks,
                       const Elimination& elimination) {
  std::vector<std::tuple<Column, std::size_t, Eigen::Index>> parts;  // each variable's column, place and first row
  Eigen::Index size = 0;
  for (const std::size_t p : places) {
    parts.emplace_back(elimination.column[blocks.block_of(p)], p, std::exchange(size, size + blocks.dof(p)));
  }
  std::ranges::sort(parts);
  std::vector<Column> columns;
  std::vector<Eigen::Index> rows;
  for (const auto& [column, p, first] : parts) {
    columns.push_back(column);
    for (int i = 0; i < blocks.dof(p); ++i) rows.push_back(first + i);
  }
  make_distinct(columns);
  auto write = [&quadratic, rows = std::move(rows)](DenseBlock to) {
    for (Eigen::Index j = 0; j < to.cols(); ++j) {
      const Eigen::Index column = rows[static_cast<std::size_t>(j)];
      for (Eigen::Index i = j; i < to.rows(); ++i) to(i, j) = quadratic.entry(rows[static_cast<std::size_t>(i)], column);
    }
  };
  return {std::move(columns), {nullptr, 0, 0, Eigen::OuterStride<>(0)}, std::move(write)};
}

/// True if one of the node's columns is among the singular ones.
bool is_singular(const FactorNode& node, const std::vector<std::int64_t>& singular, const BlockLower& matrix) {
  const auto next = std::ranges::lower_bound(singular, matrix.offsets[node.columns.first]);
  return next != singular.end() && *next < matrix.offsets[node.columns.last];
}

}  // namespace

std::vector<SumNode> eliminate(const QuadraticSum& sum) {
  const Blocks blocks(sum);
  const Elimination elimination = blocks.planned();
  std::vector<GivenFront> given;
  for (std::size_t q = 0; q < sum.quadratics.size(); ++q) {
    given.push_back(given_front(*sum.quadratics[q], blocks.places(q), blocks, elimination));
  }
  EliminatedFronts fronts = eliminate_fronts(elimination.matrix, given);
  std::erase(fronts.singular, elimination.matrix.size() - 1);  // the last column is FrontTree::kOne's, whose value is known

  const auto variables_of = [&](const auto& columns) {
    std::vector<Variable> variables;
    for (const Column column : columns) append(variables, blocks.members(elimination.order[column]));
    return variables;
  };
  std::vector<SumNode> nodes(fronts.tree.nodes.size());
  for (std::size_t n = 0; n < nodes.size(); ++n) {
    const FactorNode& from = fronts.tree.nodes[n];
    nodes[n].parent = from.parent;
    if (from.width == 0) {
      nodes[n].quadratic = from.given;
      continue;
    }
    nodes[n].front = {.frontals = variables_of(from.columns),
                      .separator = variables_of(fronts.tree.rows_of(from)),
                      .L = std::move(fronts.panels[n]),
                      .is_singular = is_singular(from, fronts.singular, elimination.matrix)};
    nodes[n].update = {nodes[n].front.separator, std::move(fronts.updates[n])};
  }
  return nodes;
}

}  // namespace mapjoin
