// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <array>
#include <limits>
#include <mapjoin/solve/elimination_tree.hpp>
#include <mapjoin/solve/factor_tasks.hpp>
#include <mapjoin/solve/supernodal_tree.hpp>
#include <numeric>
#include <utility>

namespace mapjoin {
namespace {

/// Columns of L with the same rows below them, without any zeros.
struct Columns {
  Slice columns;
  std::size_t parent;  ///< The column of the first row below; the number of columns for a root.
  Slice rows;          ///< Below them, in FundamentalSupernodes::rows.
};

/// The columns of L, from left to right, in runs of the same rows.
struct FundamentalSupernodes {
  std::vector<Columns> supernodes;
  std::vector<Index> rows;
};

/// A column goes on with the one before it where that is its child and has no other rows.
std::vector<Columns> runs_of_columns(const EliminationTree& tree) {
  std::vector<Columns> runs;
  for (std::size_t k = 0; k < tree.parent.size(); ++k) {
    const bool goes_on = k > 0 && static_cast<std::size_t>(tree.parent[k - 1]) == k && tree.counts[k - 1] == tree.counts[k] + 1;
    if (!goes_on) runs.push_back({{k, k}, 0, {}});
    runs.back().columns.end = k + 1;
    runs.back().parent = static_cast<std::size_t>(tree.parent[k]);
  }
  return runs;
}

/// The rows below each run: those of the matrix in its columns, and those of its children.
FundamentalSupernodes fundamental_supernodes(const BlockLower& A) {
  FundamentalSupernodes result{runs_of_columns(elimination_tree(A)), {}};
  constexpr std::int32_t kNone = -1;
  std::vector<std::int32_t> first_child(A.blocks() + 1, kNone);  // per column; the last one for roots
  std::vector<std::int32_t> next_child;
  std::vector<std::int32_t> seen(A.blocks(), kNone);  // per row, the last supernode that has it
  for (Columns& node : result.supernodes) {
    const auto s = static_cast<std::int32_t>(next_child.size());
    node.rows.begin = result.rows.size();
    const auto take = [&](Index row) {
      if (static_cast<std::size_t>(row) < node.columns.end) return;
      if (std::exchange(seen[static_cast<std::size_t>(row)], s) != s) result.rows.push_back(row);
    };
    for (std::size_t k = node.columns.begin; k < node.columns.end; ++k) {
      for (const Index row : A.rows_of(k)) take(row);
      for (std::int32_t c = first_child[k]; c != kNone; c = next_child[static_cast<std::size_t>(c)]) {
        const Slice below = result.supernodes[static_cast<std::size_t>(c)].rows;
        for (std::size_t r = below.begin; r < below.end; ++r) take(result.rows[r]);
      }
    }
    node.rows.end = result.rows.size();
    std::sort(result.rows.begin() + static_cast<std::ptrdiff_t>(node.rows.begin), result.rows.end());
    next_child.push_back(std::exchange(first_child[node.parent], s));
  }
  return result;
}

/// Up to `width` scalar columns, a supernode may have this share of zeros.
struct Relaxation {
  Eigen::Index width;
  double zeros;
};
constexpr std::array<Relaxation, 4> kRelaxations{
    {{4, 1.0}, {16, 0.8}, {48, 0.1}, {std::numeric_limits<Eigen::Index>::max(), 0.05}}};

/// Columns that will be one supernode, with the rows below the last of them.
struct Group {
  Columns columns;
  Eigen::Index width = 0;
  Eigen::Index below = 0;
  double entries = 0.0;  ///< Without the zeros.

  static double entries_of(Eigen::Index width, Eigen::Index below) {
    return static_cast<double>(width) * (static_cast<double>(width + 1) / 2.0 + static_cast<double>(below));
  }
};

bool should_merge(const Group& child, const Group& parent) {
  const Eigen::Index width = child.width + parent.width;
  const double zeros = 1.0 - (child.entries + parent.entries) / Group::entries_of(width, parent.below);
  const auto relaxation =
      std::find_if(kRelaxations.begin(), kRelaxations.end(), [&](const auto& r) { return width <= r.width; });
  return zeros <= relaxation->zeros;
}

Group group_of(const Columns& supernode, const FundamentalSupernodes& of, const BlockLower& A) {
  Group group{supernode};
  group.width = A.offsets[supernode.columns.end] - A.offsets[supernode.columns.begin];
  for (const Index row : supernode.rows.of(of.rows)) group.below += A.dof(static_cast<std::size_t>(row));
  group.entries = Group::entries_of(group.width, group.below);
  return group;
}

/// Supernodes that are hardly larger than their children become one with the last of these: fewer and wider panels.
std::vector<Group> relaxed(const FundamentalSupernodes& fundamental, const BlockLower& A) {
  std::vector<Group> groups;  // from the last to the first
  for (auto supernode = fundamental.supernodes.rbegin(); supernode != fundamental.supernodes.rend(); ++supernode) {
    const Group group = group_of(*supernode, fundamental, A);
    const bool depends = !groups.empty() && supernode->parent < groups.back().columns.columns.end;
    if (depends && should_merge(group, groups.back())) {
      groups.back().columns.columns.begin = group.columns.columns.begin;
      groups.back().width += group.width;
      groups.back().entries += group.entries;
    } else {
      groups.push_back(group);
    }
  }
  std::reverse(groups.begin(), groups.end());
  return groups;
}

/// The next node, of some columns and the rows below them.
FactorNode& append_node(SupernodalTree& tree, Slice columns, std::span<const Index> rows, const BlockLower& A) {
  FactorNode& node = tree.nodes.emplace_back();
  node.columns = columns;
  node.width = A.offsets[columns.end] - A.offsets[columns.begin];
  node.height = node.width;
  for (const Index row : rows) node.height += A.dof(static_cast<std::size_t>(row));
  node.first_value = tree.value_count;
  tree.value_count += node.width * node.height;
  node.rows.begin = tree.rows.size();
  tree.rows.insert(tree.rows.end(), rows.begin(), rows.end());
  node.rows.end = tree.rows.size();
  return node;
}

/// Nodes with their rows and panels; given fronts stand before the node that has the first of their rows.
void lay_out_nodes(SupernodalTree& tree, const std::vector<Group>& groups, const std::vector<Index>& rows,
                   std::span<const std::vector<Index>> given, const BlockLower& A) {
  std::vector<std::size_t> by_first_row(given.size());
  std::iota(by_first_row.begin(), by_first_row.end(), std::size_t{0});
  std::stable_sort(by_first_row.begin(), by_first_row.end(),
                   [&](std::size_t a, std::size_t b) { return given[a].front() < given[b].front(); });
  auto next = by_first_row.begin();
  for (const Group& group : groups) {
    const Slice columns = group.columns.columns;
    for (; next != by_first_row.end(); ++next) {
      const auto first = static_cast<std::size_t>(given[*next].front());
      if (first >= columns.end) break;
      append_node(tree, {first, first}, given[*next], A).given = *next;
    }
    append_node(tree, columns, group.columns.rows.of(rows), A);
  }
}

void find_parents(SupernodalTree& tree, std::size_t columns) {
  std::vector<std::size_t> node_of(columns);
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    for (std::size_t k = tree.nodes[s].columns.begin; k < tree.nodes[s].columns.end; ++k) node_of[k] = s;
  }
  for (FactorNode& node : tree.nodes) {
    const auto rows = tree.rows_of(node);
    node.parent = rows.empty() ? tree.nodes.size() : node_of[static_cast<std::size_t>(rows.front())];
  }
}

void find_children(SupernodalTree& tree) {
  std::vector<std::size_t> counts(tree.nodes.size() + 1, 0);
  for (const FactorNode& node : tree.nodes) ++counts[node.parent];
  std::size_t begin = 0;
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    tree.nodes[s].children = {begin, begin};
    begin += counts[s];
  }
  tree.children.resize(begin);
  for (std::size_t s = 0; s < tree.nodes.size(); ++s) {
    if (tree.nodes[s].parent < tree.nodes.size()) tree.children[tree.nodes[tree.nodes[s].parent].children.end++] = s;
  }
}

/// Rows below a supernode, in one run as far as they are next to each other in the parent's front.
void append_runs(SupernodalTree& tree, FactorNode& node, const BlockLower& A, const std::vector<std::int32_t>& front_row) {
  node.runs.begin = tree.runs.size();
  RowRun run;
  for (const Index block : tree.rows_of(node)) {
    const auto row = static_cast<std::size_t>(block);
    if (run.length > 0 && front_row[row] != run.to + run.length) {
      tree.runs.push_back(run);
      run = {run.from + run.length, 0, 0};
    }
    if (run.length == 0) run.to = front_row[row];
    run.length += static_cast<std::int32_t>(A.dof(row));
  }
  tree.runs.push_back(run);
  node.runs.end = tree.runs.size();
}

/// Where the entries of the matrix and the rows of the children lie in each front.
void lay_out_fronts(SupernodalTree& tree, const BlockLower& A) {
  tree.front_rows.resize(A.rows.size());
  std::vector<std::int32_t> front_row(A.blocks());
  for (const FactorNode& node : tree.nodes) {
    Eigen::Index height = 0;
    const auto place = [&](std::size_t row) {
      front_row[row] = static_cast<std::int32_t>(height);
      height += A.dof(row);
    };
    for (std::size_t k = node.columns.begin; k < node.columns.end; ++k) place(k);
    for (const Index row : tree.rows_of(node)) place(static_cast<std::size_t>(row));

    for (auto entry = A.begin[node.columns.begin]; entry < A.begin[node.columns.end]; ++entry) {
      const auto e = static_cast<std::size_t>(entry);
      tree.front_rows[e] = front_row[static_cast<std::size_t>(A.rows[e])];
    }
    for (const std::size_t child : tree.children_of(node)) append_runs(tree, tree.nodes[child], A, front_row);
  }
}

}  // namespace

SupernodalTree supernodal_tree(const BlockLower& matrix, std::span<const std::vector<Index>> given) {
  SupernodalTree tree;
  const FundamentalSupernodes fundamental = fundamental_supernodes(matrix);
  lay_out_nodes(tree, relaxed(fundamental, matrix), fundamental.rows, given, matrix);
  find_parents(tree, matrix.blocks());
  find_children(tree);
  lay_out_fronts(tree, matrix);
  tree.tasks = factor_tasks(tree);
  return tree;
}

}  // namespace mapjoin
